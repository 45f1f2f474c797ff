// SPDX-License-Identifier: BSD-3-Clause
#include "cli/text.h"
#include "drawing/map_page.h"
#include "evaluation/answer_page.h"
#include "evaluation/evaluation_report.h"
#include "tools/render_app.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>

#include <filesystem>
#include <fmt/format.h>
#include <map>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

std::map<std::string, std::size_t> indicesOf(const DepthSequence& sequence) {
  std::map<std::string, std::size_t> indices;
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) indices.emplace(sequence.frames()[i].name, i);
  return indices;
}

DrawnRun runOf(const std::string& name, const Trajectory& trajectory) {
  DrawnRun run{name, {}};
  for (const StampedPose& pose : trajectory.poses()) run.T_w_c.push_back(pose.T_w_c);
  return run;
}

}  // namespace

int RenderApp::renderMapPage(const Console& console) const {
  if (!map_.empty())
    throw UsageError(fmt::format("--map goes with images and results; {} is a map itself", input_));
  const Map map = readMap(input_);
  MapPage page;
  page.title = "Map " + fs::path(input_).stem().string();
  if (!trajectory_.empty()) page.runs.push_back(runOf("trajectory", DepthSequence::readTruth(trajectory_)));
  writeMapPage(output_, map, page);
  console.out << counted(map.models.size(), "local model") << "; page in " << output_ << "\n";
  return kOk;
}

int RenderApp::renderAnswerPage(const CommandLine& line, const Console& console) const {
  if (map_.empty()) throw UsageError("the page of results needs --map");
  const Map map = openMap(map_);
  const std::vector<RunResults> runs = readRuns(input_, [&](const std::string& text) { console.note(text); });
  if (runs.empty() || runs.front().rows.empty()) throw IoError(input_, "has no results");
  std::optional<DepthSequence> sequence;
  std::optional<Evaluation> evaluation;
  if (!sequence_.empty()) {
    sequence = openSequence(sequence_, depth_.recording, console);
    if (hasGivenPose(map) && !sequence->groundTruth().empty())
      evaluation = evaluate(runs, PlaceTruth(sequence->groundTruth()), modelPosesOf(map), evaluation_);
  }
  MapPage page = answerPage(map, runs, evaluation ? &*evaluation : nullptr);
  page.title = fmt::format("{} in {}", titleOf(input_), fs::path(map_).stem().string());
  if (!trajectory_.empty()) page.runs.push_back(runOf("trajectory", DepthSequence::readTruth(trajectory_)));
  if (evaluation) page.runs.push_back(runOf("true poses", sequence->groundTruth()));
  std::optional<ViewBuilder> builder;
  if (sequence) {
    builder.emplace(map.calibrated(depth_.camera(sequence->camera(), line)), depth_.view);
    page.view = [&, indices = indicesOf(*sequence)](std::size_t answer) -> std::optional<View> {
      const auto found = indices.find(page.answers[answer].frame);
      if (found == indices.end()) return {};
      return viewOf(*sequence, found->second, depth_.width, *builder);
    };
  }
  writeMapPage(output_, map, page);
  console.out << counted(page.answers.size(), "image") << "; page in " << output_ << "\n";
  return kOk;
}

}  // namespace facetloc
