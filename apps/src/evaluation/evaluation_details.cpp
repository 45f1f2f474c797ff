// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation_details.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <map>

namespace facetloc {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMetreStep = 0.25;  // between points of a curve [m]

std::string wholeRange(double lowest, double highest) {
  if (std::isinf(highest)) return fmt::format("{:.0f} or more", lowest);
  if (highest - lowest == 1) return fmt::format("{:.0f}", lowest);
  return fmt::format("{:.0f} to {:.0f}", lowest, highest - 1);
}

std::string realRange(double lowest, double highest) {
  return std::isinf(highest) ? fmt::format("{:.2f} or more", lowest)
                             : fmt::format("{:.2f} to {:.2f}", lowest, highest);
}

using Quantity = std::function<std::optional<double>(const FrameEvaluation&)>;

std::vector<ErrorGroup> grouped(const std::vector<FrameEvaluation>& frames, const std::vector<double>& limits,
                                std::string (*range)(double, double), const Quantity& quantity) {
  std::vector<ErrorGroup> groups;
  for (std::size_t i = 0; i + 1 < limits.size(); ++i) {
    ErrorGroup group{limits[i], limits[i + 1], 0, {}};
    std::vector<FrameEvaluation> inside;
    for (const FrameEvaluation& f : frames) {
      const auto value = quantity(f);
      if (f.unmapped || !value || *value < group.lowest || *value >= group.highest) continue;
      inside.push_back(f);
      group.mean += *value;
    }
    if (inside.empty()) continue;
    group.mean /= static_cast<double>(inside.size());
    group.summary = summarize(range(group.lowest, group.highest), inside);
    groups.push_back(std::move(group));
  }
  return groups;
}

std::optional<MissKind> missKind(const FrameEvaluation& f, bool relative) {
  const std::optional<bool> right = isRight(f, relative);
  if (f.state == AnswerState::sure && !right.value_or(true)) return MissKind::confident_wrong;
  if (f.unmapped) {
    if (f.hypotheses > 0 && f.probability >= kUnsure) return MissKind::sure_of_nothing;
    return {};
  }
  if (right.value_or(false)) return {};
  if (f.first_correct == 0 && (f.covered || f.frame_class == FrameClass::unknown)) return MissKind::not_found;
  if (f.first_correct > 1) return MissKind::not_first;
  return {};
}

/** Counts an answer at a point, and makes points up to it. */
void count(StartCurve& curve, std::size_t i, double step, bool sure, bool right) {
  while (curve.points.size() <= i) curve.points.push_back({step * static_cast<double>(curve.points.size())});
  StartCurve::Point& point = curve.points[i];
  ++point.starts;
  point.sure += sure;
  point.right += sure && right;
}

}  // namespace

std::vector<FrameEvaluation> framesInQuestion(const Evaluation& evaluation) {
  std::vector<FrameEvaluation> frames;
  for (const FrameEvaluation& f : evaluation.frames)
    if (f.frame_class == FrameClass::new_image) frames.push_back(f);
  return frames.empty() ? evaluation.frames : frames;
}

Evaluation withoutTruth(const std::vector<RunResults>& runs) {
  Evaluation evaluation;
  for (const RunResults& run : runs)
    for (const ResultRow& row : run.rows) {
      auto& frames = evaluation.frames;
      if (frames.empty() || frames.back().run != run.name || frames.back().name != row.frame) {
        frames.emplace_back();
        frames.back().run = run.name;
        frames.back().name = row.frame;
        frames.back().state = row.state;
        frames.back().reason = row.reason;
      }
      frames.back().hypotheses += row.rank > 0;
      if (row.rank != 1) continue;
      frames.back().probability = row.probability;
      if (row.T_w_c) frames.back().T_w_c = *row.T_w_c;
    }
  return evaluation;
}

std::optional<bool> isRight(const FrameEvaluation& frame, bool relative) {
  if (frame.hypotheses == 0 || !errorOf(frame, relative)) return {};
  return relative ? frame.locally_correct : frame.first_correct == 1;
}

const std::optional<PoseError>& errorOf(const FrameEvaluation& frame, bool relative) {
  return relative ? frame.local_error : frame.best_error;
}

std::vector<ErrorGroup> errorsByVisiblePlanes(const std::vector<FrameEvaluation>& frames) {
  return grouped(frames, {0, 2, 3, 4, 6, 9, 13, 18, kInfinity}, wholeRange,
                 [](const FrameEvaluation& f) { return f.visible_planes; });
}

std::vector<ErrorGroup> errorsByDistance(const std::vector<FrameEvaluation>& frames) {
  return grouped(frames, {0, 0.25, 0.5, 0.75, 1, 1.5, 2, kInfinity}, realRange, [](const FrameEvaluation& f) {
    return f.nearest ? std::optional<double>(f.nearest->distance) : std::nullopt;
  });
}

std::vector<StageTime> stageTimes(const std::vector<TimingRow>& rows) {
  std::vector<StageTime> times;
  const auto add = [&](const char* stage, const auto& time) {
    std::vector<double> ms;
    for (const TimingRow& row : rows)
      if (row.sum() != 0) ms.push_back(std::invoke(time, row));  // else it failed
    if (!ms.empty()) times.push_back({stage, Sample(std::move(ms))});
  };
  add("segmentation", &TimingRow::segment_ms);
  add("features", &TimingRow::features_ms);
  add("localization", &TimingRow::localize_ms);
  add("all", &TimingRow::sum);
  return times;
}

const char* toString(MissKind kind) {
  constexpr const char* kNames[] = {"Confident and wrong", "Sure where the map has nothing",
                                    "No correct hypothesis", "Correct, but not at rank 1"};
  return kNames[static_cast<int>(kind)];
}

std::vector<Miss> misses(const Evaluation& evaluation, bool relative) {
  std::vector<Miss> found;
  for (const FrameEvaluation& f : framesInQuestion(evaluation))
    if (const auto kind = missKind(f, relative)) found.push_back({*kind, f});
  std::stable_sort(found.begin(), found.end(), [](const Miss& a, const Miss& b) { return a.kind < b.kind; });
  return found;
}

std::vector<StartCurve> startCurves(const std::vector<StartAnswer>& answers,
                                    const std::vector<FrameEvaluation>& frames,
                                    const Eigen::Isometry3d& T_true_estimated,
                                    const EvaluationParams& params) {
  std::map<std::string, Eigen::Isometry3d> truth;
  for (const FrameEvaluation& frame : frames) truth[frame.name] = frame.T_w_c;
  StartCurve images{"images", {}}, metres{"metres", {}};
  std::string start;
  std::optional<Eigen::Isometry3d> before;  // the true pose of the image before, of the same start
  double distance = 0;
  std::size_t image = 0, next = 0;  // points of the start
  for (const StartAnswer& answer : answers) {
    const auto found = truth.find(answer.frame);
    if (found == truth.end()) continue;
    const Eigen::Isometry3d& T_w_c = found->second;
    if (!before || answer.start != start) {
      start = answer.start;
      before = T_w_c;
      distance = 0;
      image = next = 0;
    }
    distance += (T_w_c.translation() - before->translation()).norm();
    before = T_w_c;
    const bool sure = answer.state == AnswerState::sure;
    const bool right = answer.T_w_c && isNear(T_true_estimated * *answer.T_w_c, T_w_c, params.max_translation,
                                              params.max_rotation_deg);
    count(images, image++, 1, sure, right);
    for (; distance >= kMetreStep * static_cast<double>(next); ++next)
      count(metres, next, kMetreStep, sure, right);
  }
  return {images, metres};
}

}  // namespace facetloc
