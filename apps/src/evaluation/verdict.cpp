// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/verdict.h"

#include "cli/findings_file.h"
#include "cli/text.h"

#include <facetloc/features/pose.h>
#include <facetloc/localization/sure_calibration.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <utility>

namespace facetloc {
namespace {

constexpr double kPlaceDistance = 0.5, kPlaceRotationDeg = 20;  // limits of one and the same place
constexpr double kTruthShare = 3;     // limits of an answer, as multiples of the disagreement of the truth
constexpr double kTolerated = 0.005;  // share of the sure answers that may be wrong

/** Why an image has no sure answer, in the order in which reasons are looked for. */
enum class Obstacle {
  not_mapped,
  not_covered,
  few_planes,
  no_place,
  undecided,
  aliased,
  inaccurate,
  misplaced
};

std::string percent(std::size_t n, std::size_t total) {
  const double share = total == 0 ? 0 : 100.0 * static_cast<double>(n) / static_cast<double>(total);
  // 100 % means all of them.
  return n == total || share < 99.5 ? fmt::format("{:.0f}\u00a0%", share)
                                    : fmt::format("{:.1f}\u00a0%", std::min(share, 99.9));
}

double median(std::vector<double> values) { return Sample(std::move(values)).bound(0.5); }

std::string lengthText(double metres) {
  return metres < 0.1 ? fmt::format("{:.0f} mm", 1000 * metres) : fmt::format("{:.2f} m", metres);
}

bool isSamePlace(const PoseError& error) {
  return error.translation <= kPlaceDistance && error.rotation_deg <= kPlaceRotationDeg;
}

struct Errors {
  std::vector<double> metres, degrees;
  std::size_t elsewhere = 0;  // errors beyond the limits of a place

  void add(const PoseError& error) {
    metres.push_back(error.translation);
    degrees.push_back(error.rotation_deg);
    elsewhere += !isSamePlace(error);
  }
  std::string text() const {
    return fmt::format("{}off by {} and {:.1f}°{}", elsewhere == 0 ? "at the right place, " : "",
                       lengthText(median(metres)), median(degrees), metres.size() == 1 ? "" : " (median)");
  }
};

/** The counts behind the verdict. */
struct Counts {
  std::vector<FrameEvaluation> frames;
  bool relative = false;
  std::size_t sure = 0, judged = 0, right = 0, first_right = 0, places = 0;
  Errors right_errors, wrong_errors;  // errors of sure answers
  Errors inaccurate;                  // errors of others at the right place
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
  if (!right) return Obstacle::undecided;
  if (*right) return Obstacle::aliased;
  return isSamePlace(*errorOf(f, relative)) ? Obstacle::inaccurate : Obstacle::misplaced;
}

void countSure(const FrameEvaluation& f, Counts& c) {
  ++c.sure;
  const auto right = isRight(f, c.relative);
  if (!right) return;
  ++c.judged;
  c.right += *right;
  (*right ? c.right_errors : c.wrong_errors).add(*errorOf(f, c.relative));
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
    const Obstacle obstacle = obstacleOf(f, c.relative);
    ++c.obstacles[obstacle];
    if (obstacle == Obstacle::inaccurate) c.inaccurate.add(*errorOf(f, c.relative));
    if (f.hypotheses == 0) ++c.reasons[f.reason];
  }
  return c;
}

std::string rightSentence(const Counts& c, const EvaluationParams& p) {
  if (c.sure == 0) return "No answer is sure, so none can be acted on.";
  if (c.judged == 0) return "Whether these are right is not known: there are no true poses to judge them by.";
  const std::string limits = fmt::format(
      "within {:.3g} m and {:.3g}°{}", p.max_translation, p.max_rotation_deg,
      c.relative ? " of the truth in their local models, since the map lies in a frame of its own" : "");
  const std::size_t wrong = c.judged - c.right;
  const std::string these =
      c.judged == c.sure ? "these" : fmt::format("the {} of these that can be judged", c.judged);
  if (wrong == 0) return fmt::format("All of {} are right, {}.", these, limits);
  const std::string others = wrong == 1 ? "the other one is" : fmt::format("the other {} are", wrong);
  return fmt::format("{} of {} {} right ({}), {}; {} {}.", c.right, these, c.right == 1 ? "is" : "are",
                     percent(c.right, c.judged), limits, others, c.wrong_errors.text());
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
  case Obstacle::inaccurate:
    return verb("is ", "are ") + c.inaccurate.text();
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

/** Are all images taken from one point? Answers without a pose in the world do not count. */
bool stoodStill(const EvaluationReport& report, const Counts& c) {
  Eigen::AlignedBox3d way;
  std::vector<Eigen::Matrix3d> turns;
  for (const FrameEvaluation& f : c.frames) {
    if (!report.isJudged() && f.T_w_c.isApprox(Eigen::Isometry3d::Identity())) continue;
    way.extend(f.T_w_c.translation());
    turns.push_back(f.T_w_c.linear());
  }
  return !turns.empty() && way.diagonal().norm() <= kPlaceDistance &&
         std::all_of(turns.begin(), turns.end(), [&](const Eigen::Matrix3d& R) {
           return rotationAngle(turns.front().transpose() * R) <= kPlaceRotationDeg * kDegree;
         });
}

/** Would facetloc_map calibrate find a threshold by these images? */
bool canCalibrate(const EvaluationReport& report, const Counts& c) {
  if (report.own_frame || report.of_map) return false;
  constexpr double kAlpha = 0.01;
  std::vector<Eigen::Isometry3d> T_w_c;
  for (const FrameEvaluation& f : c.frames) T_w_c.push_back(f.T_w_c);
  SureCalibration calibration(kAlpha);
  for (const std::size_t i : independentImages(T_w_c))
    calibration.add(std::clamp(c.frames[i].probability, 0.0, 1.0),
                    isRight(c.frames[i], c.relative).value_or(false));
  return calibration.threshold().has_value();
}

std::string stepAgainstWrong(const EvaluationReport& report, const Counts& c) {
  if (canCalibrate(report, c))
    return "Bound the share of wrong answers: facetloc_map calibrate MAP.flmap RECORDING --alpha 0.01; then "
           "localize again.";
  double wrong = 0, right = 0;  // largest probabilities
  for (const FrameEvaluation& f : c.frames)
    if (const auto is_right = isRight(f, c.relative); is_right && f.state == AnswerState::sure)
      (*is_right ? right : wrong) = std::max(*is_right ? right : wrong, f.probability);
  for (const double least : {0.95, 0.98, 0.99, 0.995, 0.999, 0.9999})
    if (wrong < least && right >= least)
      return fmt::format("Count answers as sure from a probability of {0} on, which none of the wrong ones "
                         "reaches: facetloc_localize --min-probability {0}.",
                         least);
  return "Look at the answers below that are sure and wrong.";
}

std::string nextStep(const EvaluationReport& report, const Counts& c) {
  for (const Severity severity : {Severity::refusal, Severity::doubt})
    if (const Finding* finding = firstOf(report.findings, severity))
      return fmt::format("Settle first what is in doubt: {}.",
                         finding->cure.empty() ? finding->words : finding->cure);
  if (static_cast<double>(c.judged - c.right) > kTolerated * static_cast<double>(c.judged))
    return stepAgainstWrong(report, c);
  const auto sorted = byNumber(c.obstacles);
  const std::size_t others = c.frames.size() - c.sure;
  if (10 * others <= c.frames.size()) {
    if (report.of_map)
      return "Localize a later recording of the place, since these are the images of the map: facetloc try "
             "RECORDING LATER.";
    if (stoodStill(report, c))
      return "Localize a recording of a camera that moves through the place, since these images show one "
             "view: facetloc try RECORDING LATER.";
    return "The map is ready to be used: facetloc_live --map MAP.flmap.";
  }
  const char* drive = ", or localize the whole drive: facetloc_localize --sequence";
  switch (sorted[0].first) {
  case Obstacle::not_mapped:
  case Obstacle::not_covered:
    return "Record the places that the map lacks, and add them: facetloc_map extend MAP.flmap RECORDING -o "
           "LARGER.flmap.";
  case Obstacle::few_planes:
    return fmt::format("Let the camera see planes of three directions (turn it, or tilt it to the floor){}.",
                       report.as_drive ? "" : drive);
  case Obstacle::no_place:
  case Obstacle::misplaced:
    return fmt::format("Look at the failures below{}.",
                       report.of_map ? "" : "; if furniture has moved, update the map: facetloc_map extend");
  case Obstacle::undecided:
  case Obstacle::aliased:
  case Obstacle::inaccurate:
    break;
  }
  if (report.as_drive)
    return "Add what distinguishes places that look the same: an odometry, or the start of the drive "
           "(facetloc_localize --sequence --odometry FILE, or --near).";
  return "Localize the whole drive instead of single images, which distinguishes places that look the same: "
         "facetloc_localize --sequence.";
}

/** The disagreement of the true poses with the images. Poses that are refused say nothing. */
PoseError disagreementOfTruth(const Findings& findings) {
  PoseError worst;
  for (const Finding& finding : findings) {
    if (finding.id.rfind("poses.", 0) != 0 || finding.severity == Severity::refusal) continue;
    for (const Evidence& number : finding.evidence) {
      if (number.quantity == "rotation_deg") worst.rotation_deg = std::max(worst.rotation_deg, number.value);
      if (number.quantity == "translation_m") worst.translation = std::max(worst.translation, number.value);
    }
  }
  return worst;
}

std::vector<std::string> remarksOf(const EvaluationReport& report) {
  std::vector<std::string> remarks;
  const PoseError truth = disagreementOfTruth(report.findings);
  const auto sets = [](double of_truth, double limit) {
    return of_truth > 0 && kTruthShare * of_truth >= limit;
  };
  if (sets(truth.translation, report.params.max_translation) ||
      sets(truth.rotation_deg, report.params.max_rotation_deg))
    remarks.push_back(
        fmt::format("The true poses disagree with the images by {:.2f}° and {}, so that answers "
                    "within {:.0f} times that count as right.",
                    truth.rotation_deg, lengthText(truth.translation), kTruthShare));
  if (report.map_alignment)
    remarks.push_back(
        fmt::format("The map lies in a frame of its own and is bent by {:.1f}° and {} (RMS, its {} against "
                    "their true poses).",
                    report.map_alignment->rotation_residual_deg, lengthText(report.map_alignment->residual),
                    counted(report.map_alignment->used, "local model")));
  for (const Finding& finding : report.findings)
    if (finding.severity >= Severity::doubt) remarks.push_back(fmt::format("In doubt: {}.", finding.text()));
  return remarks;
}

/** How good sure answers are; or how far the others got, as far as that is known. */
KeyFigure errorFigure(const Counts& c) {
  if (const Errors& e = c.right_errors; !e.metres.empty())
    return {fmt::format("{}, {:.2f}°", lengthText(median(e.metres)), median(e.degrees)),
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
              : KeyFigure{fmt::format("{:.0f} ms", times.back().ms.bound(0.5)),
                          "per image, in the median, on one core"}};
}

}  // namespace

bool judgesRelatively(const EvaluationReport& report) {
  const auto& frames = report.evaluation.frames;
  return report.own_frame && std::any_of(frames.begin(), frames.end(), [](const FrameEvaluation& f) {
           return f.state == AnswerState::sure && f.local_error;
         });
}

EvaluationParams withinTruth(const EvaluationParams& given, const Findings& findings) {
  const PoseError truth = disagreementOfTruth(findings);
  EvaluationParams limits = given;
  limits.max_translation =
      std::max(given.max_translation, std::min(kTruthShare * truth.translation, kPlaceDistance));
  limits.max_rotation_deg =
      std::max(given.max_rotation_deg, std::min(kTruthShare * truth.rotation_deg, kPlaceRotationDeg));
  return limits;
}

Findings knownFindings(const std::vector<std::string>& files, const std::filesystem::path& results,
                       const std::vector<RunResults>& runs) {
  Findings all;
  const auto add = [&all](const std::filesystem::path& file) {
    for (Finding& finding : readFindings(file))
      if (std::none_of(all.begin(), all.end(), [&](const Finding& other) {
            return other.id == finding.id && other.words.find(finding.words) != std::string::npos;
          }))
        all.push_back(std::move(finding));
  };
  for (const std::string& file : files) add(file);
  for (const RunResults& run : runs)
    if (const auto file = results / run.name / kFindingsFile; std::filesystem::exists(file)) add(file);
  return all;
}

void printFindings(std::ostream& out, const Findings& findings) {
  if (!findings.empty()) out << "Findings\n" << toString(findings) << "\n";
}

Verdict verdictOf(const EvaluationReport& report) {
  const Counts c = countsOf(report);
  Verdict verdict;
  const char* which = c.frames.size() < report.evaluation.frames.size() ? "new " : "";
  verdict.sentences = {fmt::format("Of {} {}image{}, {} {} a sure answer ({}).", c.frames.size(), which,
                                   c.frames.size() == 1 ? "" : "s", c.sure, c.sure == 1 ? "has" : "have",
                                   percent(c.sure, c.frames.size())),
                       rightSentence(c, report.params), obstacleSentence(c)};
  verdict.remarks = remarksOf(report);
  verdict.next = nextStep(report, c);
  verdict.figures = keyFigures(c, stageTimes(report.timing));
  return verdict;
}

void printVerdict(std::ostream& out, const Verdict& verdict) {
  for (const std::string& sentence : verdict.sentences) out << sentence << "\n";
  for (const std::string& remark : verdict.remarks) out << remark << "\n";
  out << "Next: " << verdict.next << "\n";
}

}  // namespace facetloc
