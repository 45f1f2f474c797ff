// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/verdict.h"

#include "cli/text.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <utility>

namespace facetloc {
namespace {

/** Why an image has no sure answer, in the order in which reasons are looked for. */
enum class Obstacle { not_mapped, not_covered, few_planes, no_place, undecided, aliased, misplaced };

std::string percent(std::size_t n, std::size_t total) {
  const double share = total == 0 ? 0 : 100.0 * static_cast<double>(n) / static_cast<double>(total);
  // 100 % means all of them.
  return n == total || share < 99.5 ? fmt::format("{:.0f}\u00a0%", share)
                                    : fmt::format("{:.1f}\u00a0%", std::min(share, 99.9));
}

double median(std::vector<double> values) { return cumulativeHistogram(std::move(values)).bound(0.5); }

std::string lengthText(double metres) {
  return metres < 0.1 ? fmt::format("{:.0f} mm", 1000 * metres) : fmt::format("{:.2f} m", metres);
}

/** The counts behind the verdict. */
struct Counts {
  std::vector<FrameEvaluation> frames;
  bool relative = false;
  std::size_t sure = 0, judged = 0, right = 0, first_right = 0, places = 0;
  std::vector<double> metres, degrees;              // errors of sure answers that are right
  std::vector<double> wrong_metres, wrong_degrees;  // errors of sure answers that are wrong
  std::map<Obstacle, std::size_t> obstacles;
  std::map<std::string, std::size_t> reasons;  // why there is no place
};

Obstacle obstacleOf(const FrameEvaluation& f, bool relative) {
  const bool coverage_known = f.frame_class != FrameClass::unknown;
  if (f.unmapped) return Obstacle::not_mapped;
  if (coverage_known && !f.covered && !relative) return Obstacle::not_covered;
  if (f.solvable && !*f.solvable) return Obstacle::few_planes;
  if (f.hypotheses == 0) return Obstacle::no_place;
  const auto right = isRight(f, relative);
  return !right ? Obstacle::undecided : *right ? Obstacle::aliased : Obstacle::misplaced;
}

void countSure(const FrameEvaluation& f, Counts& c) {
  ++c.sure;
  const auto right = isRight(f, c.relative);
  if (!right) return;
  ++c.judged;
  const PoseError& error = c.relative ? *f.local_error : *f.best_error;
  if (*right) ++c.right;
  (*right ? c.metres : c.wrong_metres).push_back(error.translation);
  (*right ? c.degrees : c.wrong_degrees).push_back(error.rotation_deg);
}

Counts countsOf(const EvaluationReport& report) {
  Counts c;
  c.frames = framesInQuestion(report.evaluation);
  c.relative = judgesRelatively(report);
  for (const FrameEvaluation& f : c.frames) {
    c.first_right += isRight(f, c.relative).value_or(false);
    c.places += f.hypotheses > 0;
    if (f.state == AnswerState::sure) {
      countSure(f, c);
      continue;
    }
    ++c.obstacles[obstacleOf(f, c.relative)];
    if (f.hypotheses == 0) ++c.reasons[f.reason];
  }
  return c;
}

std::string rightSentence(const Counts& c, const EvaluationParams& p) {
  if (c.sure == 0) return "No answer is sure, so none can be acted on.";
  if (c.judged == 0) return "Whether these are right is not known: there are no true poses to judge them by.";
  const std::string limits = fmt::format(
      "within {:.9g} m and {:.9g}°{}", p.max_translation, p.max_rotation_deg,
      c.relative ? " of the truth in their local models, since the map lies in a frame of its own" : "");
  const std::size_t wrong = c.judged - c.right;
  if (wrong == 0) return fmt::format("All of these are right, {}.", limits);
  const std::string others = wrong == 1 ? "the other one is off" : fmt::format("the other {} are off", wrong);
  return fmt::format("{} of these {} right ({}), {}; {} by {} and {:.1f}°{}.", c.right,
                     c.right == 1 ? "is" : "are", percent(c.right, c.judged), limits, others,
                     lengthText(median(c.wrong_metres)), median(c.wrong_degrees),
                     wrong == 1 ? "" : " (median)");
}

/** The share of images with an obstacle, from the verb on. */
std::string obstacleText(Obstacle obstacle, std::size_t n, const Counts& c) {
  const auto verb = [n](const char* one, const char* many) { return std::string(n == 1 ? one : many); };
  switch (obstacle) {
  case Obstacle::not_mapped:
    return verb("shows a place", "show places") + " that the map lacks";
  case Obstacle::not_covered:
    return fmt::format("{} taken more than {:.9g} m or {:.9g}° from every local model", verb("was", "were"),
                       kCoveredDistance, kCoveredRotationDeg);
  case Obstacle::few_planes:
    return verb("shares", "share") + " too few planes with the map to fix a pose";
  case Obstacle::no_place: {
    const auto most = std::max_element(c.reasons.begin(), c.reasons.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    return verb("fits", "fit") + " no place" +
           (most->first.empty() ? "" : fmt::format(" (mostly: {})", most->first));
  }
  case Obstacle::undecided:
    return verb("fits", "fit") + " several places, or one that is not probable enough";
  case Obstacle::aliased:
    return verb("has", "have") + " the right pose first, but not probable enough: other places look the same";
  case Obstacle::misplaced:
    break;
  }
  return verb("fits", "fit") + " another place better than the right one";
}

std::vector<std::pair<Obstacle, std::size_t>> byNumber(const std::map<Obstacle, std::size_t>& obstacles) {
  std::vector<std::pair<Obstacle, std::size_t>> sorted(obstacles.begin(), obstacles.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  return sorted;
}

std::string obstacleSentence(const Counts& c) {
  const std::size_t others = c.frames.size() - c.sure;
  if (others == 0) return "No image is left without a sure answer.";
  const auto sorted = byNumber(c.obstacles);
  if (sorted.size() == 1)
    return fmt::format("The other {} {}.", others == 1 ? "one" : std::to_string(others),
                       obstacleText(sorted[0].first, others, c));
  std::string list;
  for (std::size_t i = 0; i < sorted.size(); ++i)
    list += fmt::format("{}{} {}",
                        i == 0                   ? ""
                        : i + 1 == sorted.size() ? ", and "
                                                 : ", ",
                        sorted[i].second, obstacleText(sorted[i].first, sorted[i].second, c));
  return fmt::format("Of the other {}, {}.", others, list);
}

std::string nextStep(const Counts& c) {
  constexpr double kTolerated = 0.005;  // share of the sure answers that may be wrong
  if (static_cast<double>(c.judged - c.right) >
      kTolerated * static_cast<double>(std::max<std::size_t>(c.judged, 1)))
    return "Bound the share of wrong answers: facetloc_map calibrate MAP.flmap RECORDING --alpha 0.01, with "
           "a recording whose poses are known; then localize again.";
  const auto sorted = byNumber(c.obstacles);
  const std::size_t others = c.frames.size() - c.sure;
  if (10 * others <= c.frames.size()) return "The map is ready to be used: facetloc_live --map MAP.flmap.";
  switch (sorted[0].first) {
  case Obstacle::not_mapped:
  case Obstacle::not_covered:
    return "Record the places that the map lacks, and add them: facetloc_map extend MAP.flmap RECORDING -o "
           "LARGER.flmap.";
  case Obstacle::few_planes:
    return "Let the camera see planes of three directions (turn it, or tilt it to the floor), or localize "
           "the whole drive: facetloc_localize --sequence.";
  case Obstacle::no_place:
  case Obstacle::misplaced:
    return "Look at the failures below; if furniture has moved, update the map: facetloc_map extend.";
  case Obstacle::undecided:
  case Obstacle::aliased:
    break;
  }
  return "Localize the whole drive instead of single images, which distinguishes places that look the same: "
         "facetloc_localize --sequence.";
}

/** How good sure answers are; or how far the others got, as far as that is known. */
KeyFigure errorFigure(const Counts& c) {
  if (!c.metres.empty())
    return {fmt::format("{}, {:.2f}°", lengthText(median(c.metres)), median(c.degrees)),
            "median error of sure and right answers"};
  if (c.first_right > 0 || c.judged > 0)
    return {percent(c.first_right, c.frames.size()), "of the images have the right pose first"};
  return {percent(c.places, c.frames.size()), "of the images have a place in the map"};
}

std::vector<KeyFigure> keyFigures(const Counts& c, const std::vector<StageTime>& times) {
  return {{percent(c.sure, c.frames.size()), "of the images have a sure answer"},
          {c.judged ? percent(c.right, c.judged) : "–", "of the sure answers are right"},
          errorFigure(c),
          times.empty()
              ? KeyFigure{std::to_string(c.frames.size()), c.frames.size() == 1 ? "image" : "images"}
              : KeyFigure{fmt::format("{:.0f} ms", times.back().median),
                          "per image, in the median, on one core"}};
}

}  // namespace

bool judgesRelatively(const EvaluationReport& report) {
  const auto& frames = report.evaluation.frames;
  return report.own_frame && std::any_of(frames.begin(), frames.end(), [](const FrameEvaluation& f) {
           return f.state == AnswerState::sure && f.local_error;
         });
}

bool isPapersExperiment(const EvaluationReport& report) {
  const auto has = [&](FrameClass frame_class) {
    const auto& frames = report.evaluation.frames;
    return std::any_of(frames.begin(), frames.end(),
                       [&](const auto& f) { return f.frame_class == frame_class; });
  };
  return has(FrameClass::map_image) && has(FrameClass::new_image);
}

Verdict verdictOf(const EvaluationReport& report) {
  const Counts c = countsOf(report);
  Verdict verdict;
  const char* which = c.frames.size() < report.evaluation.frames.size() ? "new " : "";
  verdict.sentences = {fmt::format("Of {} {}image{}, {} {} a sure answer ({}).", c.frames.size(), which,
                                   c.frames.size() == 1 ? "" : "s", c.sure, c.sure == 1 ? "has" : "have",
                                   percent(c.sure, c.frames.size())),
                       rightSentence(c, report.params), obstacleSentence(c)};
  if (report.map_alignment)
    verdict.map =
        fmt::format("The map lies in a frame of its own and is bent by {:.1f}° and {} (RMS, its {} against "
                    "their true poses).",
                    report.map_alignment->rotation_residual_deg, lengthText(report.map_alignment->residual),
                    counted(report.map_alignment->used, "local model"));
  verdict.next = nextStep(c);
  verdict.figures = keyFigures(c, stageTimes(report.timing));
  return verdict;
}

void printVerdict(std::ostream& out, const Verdict& verdict) {
  for (const std::string& sentence : verdict.sentences) out << sentence << "\n";
  if (!verdict.map.empty()) out << verdict.map << "\n";
  out << "Next: " << verdict.next << "\n";
}

}  // namespace facetloc
