// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation_pictures.h"

#include "evaluation/evaluation_details.h"
#include "inputs/depth_input.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMissPrefix = "miss_";
constexpr Colour kMissing = {230, 130, 20}, kNotFirst = {200, 170, 0};

const Colour& colourOf(MissKind kind) {
  if (kind == MissKind::not_first) return kNotFirst;
  return kind == MissKind::not_found ? kMissing : kRed;
}

std::vector<DrawnRun> drawnRuns(const PlaceTruth& truth) {
  std::vector<DrawnRun> runs;
  for (const PlaceTruth::Sequence& s : truth.sequences())
    runs.push_back({s.folder.filename().string(), posesOf(s.poses),
                    kCurveColours[runs.size() % std::size(kCurveColours)]});
  if (runs.empty()) runs.push_back({"true poses", posesOf(truth.poses())});
  return runs;
}

std::vector<DrawnMarks> drawnMarks(const Evaluation& evaluation, bool relative) {
  std::vector<DrawnMarks> marks;
  for (const Miss& miss : misses(evaluation, relative)) {
    if (marks.empty() || marks.back().name != toString(miss.kind))
      marks.push_back({toString(miss.kind), {}, colourOf(miss.kind)});
    marks.back().T_w_c.push_back(miss.frame.T_w_c);
  }
  return marks;
}

/** The depth images of all runs of a place, where they are there. Of runs whose images have the same names,
 * the one that is asked for goes first. */
class RunImages {
public:
  RunImages(const PlaceTruth& truth, const Map& map) : map_(map) {
    for (const PlaceTruth::Sequence& s : truth.sequences()) {
      const auto sequence = imagesIn(s.folder);
      if (!sequence) continue;
      for (std::size_t i = 0; i < sequence->frames().size(); ++i)
        for (const std::string& run : {s.folder.filename().string(), std::string()})
          places_.emplace(std::make_pair(run, sequence->frames()[i].name), Place{sequence, i});
    }
  }

  bool has(const std::string& name) const { return places_.count({"", name}) > 0; }

  /** An image that is there, seen by its camera as the map knows it. */
  SeenImage seen(const std::string& run, const std::string& name) const {
    const auto found = places_.find({run, name});
    const Place& place = found == places_.end() ? places_.at({"", name}) : found->second;
    const DepthInput defaults;
    const auto& file = place.sequence->camera();
    ViewBuilder builder(map_.calibrated(file ? file->camera : Camera()), defaults.view);
    return see(name, place.sequence->load(place.index, defaults.width), builder);
  }

private:
  struct Place {
    std::shared_ptr<const DepthSequence> sequence;
    std::size_t index;
  };

  /** Null if there are poses alone: a report does without pictures then. */
  static std::shared_ptr<const DepthSequence> imagesIn(const fs::path& recording) try {
    return std::make_shared<const DepthSequence>(DepthSequence::open(recording));
  } catch (const IoError&) {
    return nullptr;
  }

  const Map& map_;
  std::map<std::pair<std::string, std::string>, Place> places_;  // keyed by run, or "", and name
};

void judge(const FrameEvaluation& frame, bool relative, PageAnswer& answer) {
  answer.wrong = frame.state == AnswerState::sure && !isRight(frame, relative).value_or(true);
  answer.relative = relative;
  if (const auto& error = errorOf(frame, relative)) {
    answer.error_m = error->translation;
    answer.error_deg = error->rotation_deg;
  }
  if (!relative) answer.truth = frame.T_w_c;
}

bool failed(const FrameEvaluation& frame, bool relative) {
  if (frame.unmapped) return frame.hypotheses > 0 && frame.probability >= kUnsure;
  return !isRight(frame, relative).value_or(false);
}

std::string poseDifference(double translation, double rotation_deg) {
  return fmt::format("{:.2f} m and {:.2f}°", translation, rotation_deg);
}

std::string whatFailed(const FrameEvaluation& frame, bool relative) {
  if (frame.hypotheses == 0) return "no hypothesis: " + frame.reason;
  const auto& error = errorOf(frame, relative);
  return fmt::format("{}, probability {:.2f}{}",
                     error ? poseDifference(error->translation, error->rotation_deg) + " off"
                           : "in a local model without a pose",
                     frame.probability,
                     frame.first_correct > 0 ? fmt::format(", correct at rank {}", frame.first_correct) : "");
}

std::map<std::string, int> modelIndices(const Map& map) {
  std::map<std::string, int> indices;
  for (std::size_t i = 0; i < map.models.size(); ++i) indices[map.models[i].name] = static_cast<int>(i);
  return indices;
}

int indexOf(const std::string& model, const std::map<std::string, int>& indices) {
  const auto found = indices.find(model);
  if (found == indices.end()) throw std::runtime_error("the map has no local model " + model);
  return found->second;
}

/** Images with the answers that are drawn of them. */
std::vector<Failure> drawnAnswers(const std::vector<FrameEvaluation>& frames,
                                  const std::vector<RunResults>& runs, const Map& map, bool relative) {
  const auto indices = modelIndices(map);
  std::map<std::pair<std::string, std::string>, const ResultRow*> first;  // keyed by run and frame
  for (const RunResults& run : runs)
    for (const ResultRow& row : run.rows)
      if (row.rank == 1) first[{run.name, row.frame}] = &row;

  std::vector<Failure> failures;
  for (const FrameEvaluation& frame : frames) {
    Failure failure{frame.run, frame.name, whatFailed(frame, relative), frame.probability, {}};
    const auto best = first.find({frame.run, frame.name});
    if (best != first.end()) {
      const ResultRow& row = *best->second;
      failure.answers.push_back({indexOf(row.model, indices), row.T_m_c, "rank 1: " + failure.what});
    } else {
      failure.answers.push_back({-1, Eigen::Isometry3d::Identity(), failure.what});
    }
    if (frame.nearest) {
      const int nearest = indexOf(frame.nearest->name, indices);
      failure.answers.push_back(
          {nearest, map.models[nearest].T_w_m->inverse() * frame.T_w_c,
           fmt::format("true pose in the nearest local model, {} away{}",
                       poseDifference(frame.nearest->distance, frame.nearest->angle_deg),
                       frame.unmapped ? "; the map has nothing here" : "")});
    }
    failures.push_back(std::move(failure));
  }
  return failures;
}

/** Appends both coordinates in whole millimetres. */
void append(const Eigen::Vector2d& metres, Json::Value& numbers) {
  for (const double value : {metres.x(), metres.y()})
    numbers.append(static_cast<Json::Int>(std::lround(1000 * value)));
}

/** The most confident first. */
std::vector<Failure> failuresOf(const std::vector<FrameEvaluation>& frames,
                                const std::vector<RunResults>& runs, const Map& map, bool relative) {
  std::vector<Failure> failures = drawnAnswers(frames, runs, map, relative);
  std::stable_sort(failures.begin(), failures.end(),
                   [](const Failure& a, const Failure& b) { return a.probability > b.probability; });
  return failures;
}

}  // namespace

void drawMapOfRuns(const fs::path& path, const Map& map, const PlaceTruth& truth,
                   const Evaluation& evaluation, bool relative) {
  drawFloorMap(path, map, drawnRuns(truth), drawnMarks(evaluation, relative));
}

Json::Value planData(const Map& map, const Evaluation& evaluation, const MapPage& page) {
  constexpr std::size_t kMostWalls = 20000;
  FloorPlan plan = floorPlan(map, "the plan");
  if (plan.walls.size() > kMostWalls) {
    const auto length = [](const PlanLine& wall) { return (wall.to - wall.from).squaredNorm(); };
    std::nth_element(plan.walls.begin(), plan.walls.begin() + kMostWalls, plan.walls.end(),
                     [&](const PlanLine& a, const PlanLine& b) { return length(a) > length(b); });
    plan.walls.resize(kMostWalls);
  }
  Json::Value data;
  for (const PlanLine& wall : plan.walls)
    for (const Eigen::Vector2d& end : {wall.from, wall.to})
      append(end, data[wall.height < kTallestWall / 2 ? "low" : "tall"]);
  for (const Eigen::Isometry3d& T : plan.models) append(plan.view.point(T.translation()), data["models"]);
  std::set<std::pair<std::string, std::string>> in_question;
  for (const FrameEvaluation& f : framesInQuestion(evaluation)) in_question.emplace(f.run, f.name);
  for (const PageAnswer& answer : page.answers) {
    if (!in_question.count({answer.run, answer.frame}) || (!answer.truth && answer.places.empty())) continue;
    const Eigen::Isometry3d& T_w_c = answer.truth ? *answer.truth : answer.places.front().T_w_c;
    Json::Value& poses = data["answers"][answer.wrong ? "sure and wrong" : toString(answer.state)];
    append(plan.view.point(T_w_c.translation()), poses);
    append(plan.view.direction(T_w_c.linear().col(2)), poses);
  }
  return data;
}

MapPage answerPage(const Map& map, const std::vector<RunResults>& runs, const Evaluation* evaluation,
                   bool relative) {
  const auto indices = modelIndices(map);
  const auto part = static_cast<std::size_t>(mainPart(map));
  const std::string drawn = part < map.parts.size() ? map.parts[part] : "";
  std::map<std::pair<std::string, std::string>, const FrameEvaluation*> frames;
  if (evaluation)
    for (const FrameEvaluation& frame : evaluation->frames) frames[{frame.run, frame.name}] = &frame;
  MapPage page;
  for (const RunResults& run : runs) {
    const std::size_t first = page.answers.size();
    for (const ResultRow& row : run.rows) {
      if (page.answers.size() == first || page.answers.back().frame != row.frame) {
        PageAnswer begun;
        begun.run = run.name;
        begun.frame = row.frame;
        begun.state = row.state;
        begun.reason = row.reason;
        const auto judged = frames.find({run.name, row.frame});
        if (judged != frames.end()) judge(*judged->second, relative, begun);
        const auto shares = run.shares.find(row.frame);
        if (shares != run.shares.end()) begun.shares = shares->second;
        page.answers.push_back(std::move(begun));
      }
      if (row.rank == 0 || !row.T_w_c || row.part != drawn) continue;
      PageAnswer& answer = page.answers.back();
      const auto covariance = run.covariances.find(row.frame);
      if (row.rank == 1 && covariance != run.covariances.end()) answer.P_w_c = covariance->second;
      answer.places.push_back({indexOf(row.model, indices), row.T_m_c, *row.T_w_c, row.probability,
                               row.sd_trans_m, row.sd_rot_deg});
    }
  }
  return page;
}

MapPage pageOfAnswers(const Map& map, const PlaceTruth& truth, const std::vector<RunResults>& runs,
                      const Evaluation& evaluation, bool relative) {
  MapPage page = answerPage(map, runs, &evaluation, relative);
  if (!relative && !truth.poses().empty()) page.runs = drawnRuns(truth);
  const auto images = std::make_shared<const RunImages>(truth, map);
  page.view = [images, answers = page.answers](std::size_t i) -> std::optional<View> {
    if (!images->has(answers[i].frame)) return {};
    return images->seen(answers[i].run, answers[i].frame).view;
  };
  return page;
}

std::vector<Miss> chosenMisses(const Evaluation& evaluation, std::size_t most, bool relative) {
  std::map<MissKind, std::vector<Miss>> by_kind;
  for (const Miss& miss : misses(evaluation, relative)) by_kind[miss.kind].push_back(miss);
  std::map<MissKind, std::size_t> shares;
  std::size_t total = 0;
  for (bool any = true; any && total < most;) {
    any = false;
    for (const auto& [kind, of_kind] : by_kind)
      if (total < most && shares[kind] < of_kind.size()) ++shares[kind], ++total, any = true;
  }
  std::vector<Miss> chosen;
  for (const auto& [kind, of_kind] : by_kind)  // spread out: neighbours in a run look the same
    for (std::size_t i = 0; i < shares[kind]; ++i)
      chosen.push_back(of_kind[i * of_kind.size() / shares[kind]]);
  return chosen;
}

void removeMisses(const fs::path& folder) {
  if (!fs::is_directory(folder)) return;
  std::vector<fs::path> pictures;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.path().filename().string().rfind(kMissPrefix, 0) == 0 && entry.path().extension() == ".png")
      pictures.push_back(entry.path());
  for (const fs::path& picture : pictures) fs::remove(picture);
}

std::vector<ReportPicture> drawMisses(const fs::path& folder, const std::vector<Miss>& misses, const Map& map,
                                      const PlaceTruth& truth, const std::vector<RunResults>& runs,
                                      bool relative, const Console& console) {
  const RunImages images(truth, map);
  std::vector<FrameEvaluation> drawn;
  for (const Miss& miss : misses)
    if (images.has(miss.frame.name)) drawn.push_back(miss.frame);

  std::vector<ReportPicture> pictures;
  if (!drawn.empty()) fs::create_directories(folder);
  for (const Failure& failure : failuresOf(drawn, runs, map, relative)) {
    const std::string run = failure.run.empty() ? "" : failure.run + "_";
    const fs::path path = folder / fmt::format("{}{}{}.png", kMissPrefix, run, failure.frame);
    try {
      writePng(path, matchesPicture(images.seen(failure.run, failure.frame), map, failure.answers));
      pictures.push_back({path, fmt::format("{}{}: {}", run, failure.frame, failure.what)});
    } catch (const std::exception& e) {
      console.note(fmt::format("a picture of {} is missing: {}", failure.frame, e.what()));
    }
  }
  return pictures;
}

bool drawExamples(const fs::path& path, const Evaluation& evaluation, const Map& map, const PlaceTruth& truth,
                  const std::vector<RunResults>& runs, bool relative) {
  constexpr std::size_t kOfRun = 4;
  const RunImages images(truth, map);
  std::map<std::string, std::vector<FrameEvaluation>> right;  // keyed by run
  for (const FrameEvaluation& frame : evaluation.frames)
    if (images.has(frame.name) && frame.hypotheses > 0 && isRight(frame, relative).value_or(false))
      right[frame.run].push_back(frame);
  std::vector<FrameEvaluation> chosen;
  for (std::size_t i = 0; i < kOfRun; ++i)
    for (const auto& [run, frames] : right)
      chosen.push_back(frames[(2 * i + 1) * frames.size() / (2 * kOfRun)]);
  std::vector<Raster<std::uint8_t>> pictures;
  std::vector<std::string> titles;
  for (const Failure& answer : drawnAnswers(chosen, runs, map, relative)) {
    pictures.push_back(matchesPicture(images.seen(answer.run, answer.frame), map, {answer.answers.front()}));
    titles.push_back(answer.run + " " + answer.frame);
  }
  if (!pictures.empty()) writePng(path, contactSheet(pictures, titles));
  return !pictures.empty();
}

std::vector<Failure> findFailures(const Evaluation& evaluation, const std::vector<RunResults>& runs,
                                  const Map& map, bool relative) {
  std::vector<FrameEvaluation> frames;
  for (const FrameEvaluation& frame : evaluation.frames)
    if (failed(frame, relative)) frames.push_back(frame);
  return failuresOf(frames, runs, map, relative);
}

}  // namespace facetloc
