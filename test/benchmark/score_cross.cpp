// SPDX-License-Identifier: BSD-3-Clause
//
// How often is an answer sure in a map of another place, where every answer is wrong?
//
//   score_cross [--every N] [--csv FILE] [--GROUP.PARAMETER VALUE] MAPS... RECORDINGS...
//
// MAPS end in .flmap, the rest are RECORDINGS; of a folder with a run query/, that run. Each recording is
// localized image by image in the maps of all other places. A place is called by the name of the map's file,
// and a recording by its own, or a run by its folder's; PLACE:PATH calls it otherwise.
#include "batch/batch.h"
#include "cli/app.h"
#include "cli/text.h"
#include "inputs/depth_input.h"
#include "inputs/localization_options.h"
#include "programs.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/localization/localizer.h>
#include <facetloc/localization/sure_calibration.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace facetloc;

constexpr std::array<double, 4> kThresholds = {0.5, 0.9, 0.99, 0.999};

/** A map or a recording, and the place that it is of. */
struct Input {
  std::string place;
  fs::path path;
};

struct Answer {
  std::string map, recording, frame;
  double probability = 0, score = 0;
};

bool isRun(const std::string& name) {
  return name == "map" || name == "query" || name == "drive" || name == "depth";
}

std::string nameOf(fs::path path) {
  path = fs::absolute(path).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  while (isRun(path.stem().string())) path = path.parent_path();
  return fs::is_directory(path) ? path.filename().string() : path.stem().string();
}

Input inputOf(const std::string& argument) {
  const auto colon = argument.find(':');
  const bool named = colon != std::string::npos && !fs::exists(argument);
  Input input{named ? argument.substr(0, colon) : "", named ? argument.substr(colon + 1) : argument};
  if (input.place.empty()) input.place = nameOf(input.path);
  if (!fs::exists(input.path)) throw IoError(input.path.string(), "does not exist");
  if (fs::is_directory(input.path / "query")) input.path /= "query";
  return input;
}

std::string percent(std::size_t n, std::size_t of) {
  return of == 0 ? "-" : fmt::format("{:.2f} %", benchmarks::percent(n, of));
}

class CrossApp : public App {
public:
  CrossApp()
      : App("score_cross", "MAPS... RECORDINGS... [options]",
            "Localizes each recording in the maps of all other places, where every answer is wrong, and "
            "tells "
            "how many are probable.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("MAPS... RECORDINGS...", inputs_);
    line.addOption("every", every_, "N", "Ask every N-th image of a recording.");
    line.addOption("csv", csv_, "FILE", "Write each answer to this file.");
    input_.addOptions(line);
    addLocalizationOptions(line, localization_);
  }

  int execute(const CommandLine& line, const Console& console) override {
    if (every_ < 1) throw UsageError("every must be positive");
    std::vector<Input> maps, recordings;
    for (const std::string& argument : inputs_) {
      const Input input = inputOf(argument);
      (input.path.extension() == ".flmap" ? maps : recordings).push_back(input);
    }
    if (maps.empty() || recordings.empty()) throw UsageError("at least one map and one recording");
    TextTable table({"map", "recordings", "images", "p >= 0.5", "0.9", "0.99", "0.999", "highest p"});
    std::vector<Answer> all;
    for (const Input& map : maps) {
      const std::vector<Answer> of_map = answersIn(map, recordings, line, console);
      std::size_t others = 0;
      for (const Input& recording : recordings) others += recording.place != map.place;
      addRow(table, map.place, others, of_map);
      all.insert(all.end(), of_map.begin(), of_map.end());
    }
    addRow(table, "all", recordings.size(), all);
    console.out << table;
    std::size_t sure = 0;
    for (const Answer& answer : all) sure += answer.probability >= kThresholds[1];
    console.out << fmt::format(
        "of {} images, none of which the map holds, {} are sure at p >= 0.9: {}, with 95 % "
        "confidence at most {:.2f} %\n",
        all.size(), sure, percent(sure, all.size()), 100 * upperLimitOfShare(sure, all.size(), 0.95));
    if (!csv_.empty()) write(all);
    return kOk;
  }

  std::vector<Answer> answersIn(const Input& of_map, const std::vector<Input>& recordings,
                                const CommandLine& line, const Console& console) const {
    const auto map = std::make_shared<const Map>(openMap(of_map.path));
    const Localizer localizer(map, {}, localization_);
    std::vector<Answer> answers;
    for (const Input& recording : recordings) {
      if (recording.place == of_map.place) continue;
      const DepthSequence sequence = openSequence(recording.path.string(), input_.recording, console);
      const Camera camera = map->calibrated(input_.camera(sequence.camera(), line));
      const auto every = static_cast<std::size_t>(every_);
      const std::size_t n = (sequence.frames().size() + every - 1) / every;
      std::vector<std::optional<Answer>> found(n);
      Batch batch(threads(), n, console);
      std::vector<ViewBuilder> builders(batch.workers(), ViewBuilder(camera, input_.view));
      batch.run([&](std::size_t i) { return sequence.frames()[i * every].path.string(); },
                [&](std::size_t i, int worker) {
                  const View view = viewOf(sequence, i * every, input_.width, builders[worker]);
                  const Localization answer = localizer.localize(view);
                  found[i] = {of_map.place, recording.place, sequence.frames()[i * every].name};
                  if (answer.hypotheses.empty()) return;
                  found[i]->probability = answer.hypotheses.front().probability;
                  found[i]->score = answer.hypotheses.front().score;
                });
      batch.report();
      for (const std::optional<Answer>& answer : found)
        if (answer) answers.push_back(*answer);
    }
    return answers;
  }

  static void addRow(TextTable& table, const std::string& name, std::size_t recordings,
                     const std::vector<Answer>& answers) {
    std::vector<std::string> cells = {name, std::to_string(recordings), std::to_string(answers.size())};
    double highest = 0;
    for (const Answer& answer : answers) highest = std::max(highest, answer.probability);
    for (const double threshold : kThresholds)
      cells.push_back(percent(
          static_cast<std::size_t>(std::count_if(
              answers.begin(), answers.end(), [&](const Answer& a) { return a.probability >= threshold; })),
          answers.size()));
    cells.push_back(fmt::format("{:.4f}", highest));
    table.add(cells);
  }

  void write(const std::vector<Answer>& answers) const {
    writeTextAtomically(csv_, [&](std::ostream& out) {
      out << "map,recording,frame,probability,score\n";
      for (const Answer& a : answers)
        out << fmt::format("{},{},{},{:.6f},{:.3f}\n", a.map, a.recording, a.frame, a.probability, a.score);
    });
  }

  std::vector<std::string> inputs_;
  int every_ = 1;
  std::string csv_;
  DepthInput input_;
  GlobalLocalizationParams localization_;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<CrossApp>(argc, argv); }
