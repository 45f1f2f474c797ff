// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/pose_check.h"

#include "base/median.h"
#include "base/pose_axes.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

namespace facetloc {

using namespace internal;

namespace {

constexpr std::size_t kEnough = 5;                      // motions
constexpr std::size_t kEnoughToRefuse = 10;             // fewer come from places that images confuse
constexpr double kDegrees = 1, kMetres = 0.02;          // equally weighted parts of a disagreement
constexpr double kFineDegrees = 1, kFineMetres = 0.02;  // poses as good as that have no fault worth a word
constexpr double kFarDegrees = 3, kFarMetres = 0.04;    // beyond those of usable public recordings
constexpr double kSenselessDegrees = 5, kSenselessMetres = 0.2;
constexpr double kBetter = 0.5;     // share of the disagreement that is left without a fault
constexpr double kOutlying = 5;     // times the usual disagreement
constexpr double kMostTail = 0.15;  // share of outlying motions that images alone get wrong

enum class Axes { optical, base, opengl };

/** Signs of x and y in the images, if they are stored otherwise than they were seen. */
struct Storing {
  int x = 1, y = 1;
  bool isUsual() const { return x == 1 && y == 1; }
};

/** One way to read poses. */
struct Reading {
  bool w_first = false, inverse = false;
  Axes axes = Axes::optical;
  Storing storing{};
  double delay = 0;  // delay of the pose after its image [s]
  double scale = 1;  // scale of translations
};

Eigen::Isometry3d read(const Reading& reading, Eigen::Isometry3d T) {
  T = poseAsMeant(reading.w_first, reading.inverse, T);
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  if (reading.axes == Axes::base) R = opticalInBase();
  if (reading.axes == Axes::opengl) R = opticalInOpenGl();
  T.linear() = T.linear() * R;
  T.translation() *= reading.scale;
  return T;
}

Eigen::Isometry3d read(const Storing& storing, Eigen::Isometry3d T) {
  const Eigen::Matrix3d S = Eigen::Vector3d(storing.x, storing.y, 1).asDiagonal();
  T.linear() = S * T.linear() * S;
  T.translation() = S * T.translation();
  return T;
}

struct Pair {
  Eigen::Isometry3d by_poses, by_images;
};

struct Error {
  double degrees, metres;
  double cost() const { return degrees / kDegrees + metres / kMetres; }
};

Error errorOf(const Pair& pair) {
  const Eigen::Isometry3d d = pair.by_images.inverse() * pair.by_poses;
  return {rotationAngle(d.linear()) / kDegree, d.translation().norm()};
}

PoseDisagreement disagreementOf(const std::vector<Pair>& pairs) {
  if (pairs.empty()) return {};
  std::vector<double> degrees, metres;
  for (const Pair& pair : pairs) {
    const Error e = errorOf(pair);
    degrees.push_back(e.degrees), metres.push_back(e.metres);
  }
  return {median(std::move(degrees)), median(std::move(metres)), pairs.size()};
}

/** The remaining disagreement under one interpretation of the poses. */
class Trial {
public:
  Trial(const std::vector<SeenMotion>& motions, const PosesByTime& poses)
      : motions_(motions), poses_(poses) {}

  double cost(const Reading& reading) const {
    const std::vector<Pair> found = pairs(reading);
    if (found.size() < std::max(kEnough, motions_.size() / 2)) return std::numeric_limits<double>::infinity();
    std::vector<double> costs;
    for (const Pair& pair : found) costs.push_back(errorOf(pair).cost());
    std::sort(costs.begin(), costs.end());
    costs.resize(costs.size() - costs.size() / 4);  // motions that were not seen right
    return std::accumulate(costs.begin(), costs.end(), 0.0) / static_cast<double>(costs.size());
  }
  std::vector<Pair> pairs(const Reading& reading) const {
    std::vector<Pair> out;
    for (const SeenMotion& motion : motions_) {
      const auto a = poses_(motion.stamp_a + reading.delay), b = poses_(motion.stamp_b + reading.delay);
      if (a && b)
        out.push_back({read(reading, *a).inverse() * read(reading, *b), read(reading.storing, motion.T_a_b)});
    }
    return out;
  }

  Reading bestConvention() const {
    Reading best;
    double least = kBetter * cost(best);
    const auto tryOne = [&](const Reading& reading) {
      if (const double c = cost(reading); c < least) best = reading, least = c;
    };
    for (const bool w_first : {false, true})
      for (const bool inverse : {false, true})
        for (const Axes axes : {Axes::optical, Axes::base, Axes::opengl})
          tryOne({w_first, inverse, axes, {}, 0, 1});
    for (const Storing storing : {Storing{-1, 1}, Storing{1, -1}, Storing{-1, -1}})
      tryOne({false, false, Axes::optical, storing, 0, 1});
    return best;
  }

  /** The same reading with another clock, if that explains more than half. */
  Reading withBestDelay(Reading reading) const {
    constexpr double kFarthest = 1, kCoarse = 0.02, kFine = 0.005;  // [s]
    const double as_given = cost(reading);
    const auto search = [&](double from, double to, double step) {
      Reading best = reading;
      double least = std::numeric_limits<double>::infinity();
      for (int i = 0; from + i * step <= to; ++i) {
        Reading shifted = reading;
        shifted.delay = from + i * step;
        if (const double c = cost(shifted); c < least) best = shifted, least = c;
      }
      return best;
    };
    Reading best = search(-kFarthest, kFarthest, kCoarse);
    best = search(best.delay - kCoarse, best.delay + kCoarse, kFine);
    return cost(best) < kBetter * as_given ? best : reading;
  }

  Reading withBestScale(Reading reading) const {
    std::vector<double> ratios;
    for (const Pair& p : pairs(reading))
      if (const double n = p.by_poses.translation().norm(); n > 0)
        ratios.push_back(p.by_images.translation().norm() / n);
    Reading scaled = reading;
    if (!ratios.empty()) scaled.scale *= median(std::move(ratios));
    return cost(scaled) < kBetter * cost(reading) ? scaled : reading;
  }

private:
  const std::vector<SeenMotion>& motions_;
  const PosesByTime& poses_;
};

std::string toString(const Reading& r) {
  std::vector<std::string> faults;
  if (r.w_first) faults.emplace_back("their quaternions are in the order w x y z, where x y z w is expected");
  if (r.inverse)
    faults.emplace_back("they are inverted: of the world in the camera, not of the camera in the world");
  if (r.axes == Axes::base)
    faults.emplace_back(
        "they are of a robot's axes (x forward, z up), not of the camera's optical frame (x right, "
        "y down, z forward)");
  if (r.axes == Axes::opengl)
    faults.emplace_back(
        "they are of axes with y up and z backward, not of the camera's optical frame (x right, y "
        "down, z forward)");
  if (r.storing.x < 0 && r.storing.y < 0)
    faults.emplace_back("the images are turned by 180 deg against the camera of their poses");
  else if (!r.storing.isUsual())
    faults.push_back(fmt::format("the images are mirrored, {}, or the world of the poses is",
                                 r.storing.x < 0 ? "left to right" : "top to bottom"));
  if (r.delay != 0)
    faults.push_back(fmt::format("their clock is another one: the pose of an image is stamped {:.2f} s {}",
                                 std::abs(r.delay), r.delay > 0 ? "later" : "earlier"));
  if (r.scale != 1)
    faults.push_back(fmt::format("the images' motions are {:.3f} times as long: look at depth_scale of "
                                 "camera.ini and at the unit of the poses",
                                 r.scale));
  return fmt::format("{}", fmt::join(faults, "; "));
}

/** "wxyz,inverse": the words of PoseReading. */
std::string conventionOf(const Reading& r) {
  std::vector<const char*> words;
  if (r.w_first) words.push_back("wxyz");
  if (r.inverse) words.push_back("inverse");
  if (r.axes != Axes::optical) words.push_back(r.axes == Axes::base ? "base" : "opengl");
  return fmt::format("{}", fmt::join(words, ","));
}

constexpr double kWorthAWord = 0.07;  // reported deviation of ratios: systematic depth errors shorten motions
constexpr double kSenselessRatio = 0.1;
constexpr double kOtherAxisDeg = 1.5;

void compareLengths(const std::vector<SeenMotion>& motions, const PosesByTime& poses, PoseCheck& check) {
  std::vector<MotionVectors> ways, turns;
  for (const SeenMotion& motion : motions) {
    const auto a = poses(motion.stamp_a), b = poses(motion.stamp_b);
    if (!a || !b) continue;
    const Eigen::Isometry3d T = a->inverse() * *b;
    ways.push_back({motion.T_a_b.translation(), T.translation(), motion.stamp_a});
    turns.push_back({logSO3(motion.T_a_b.linear()), logSO3(T.linear()), motion.stamp_a});
  }
  check.distances = motionRatio(std::move(ways));
  check.turns = motionRatio(std::move(turns));
}

void findOutliers(const std::vector<SeenMotion>& motions, const PosesByTime& poses, PoseCheck& check) {
  const double degrees = kOutlying * std::max(check.as_given.rotation_deg, kFineDegrees / kOutlying),
               metres = kOutlying * std::max(check.as_given.translation, kFineMetres / kOutlying);
  for (const SeenMotion& motion : motions) {
    const auto a = poses(motion.stamp_a), b = poses(motion.stamp_b);
    if (!a || !b) continue;
    const Error error = errorOf({a->inverse() * *b, motion.T_a_b});
    if (error.degrees > degrees || error.metres > metres)
      check.outliers.push_back({motion.stamp_a, motion.stamp_b, error.degrees, error.metres});
  }
  if (check.as_given.motions > 0)
    check.tail = static_cast<double>(check.outliers.size()) / static_cast<double>(check.as_given.motions);
}

std::string turnsInWords(const MotionRatio& r) {
  return fmt::format("the images turn {:.3f} times as much as their poses (+- {:.3f})", r.ratio, r.std);
}

std::string distancesInWords(const MotionRatio& r) {
  return fmt::format("the images' motions are {:.3f} times as long as those of their poses (+- {:.3f})",
                     r.ratio, r.std);
}

std::string axesInWords(const MotionRatio& r) {
  return fmt::format("the images turn about axes that are {:.1f} deg from those of their poses (+- {:.1f})",
                     r.angle_deg, r.angle_std_deg);
}

std::string directionsInWords(const MotionRatio& r) {
  return fmt::format(
      "the images move in directions that are {:.1f} deg from those of their poses (+- {:.1f})", r.angle_deg,
      r.angle_std_deg);
}

/** Turns do not depend on depth_scale, so that focal lengths come first. */
std::string faultOfLengths(const PoseCheck& check) {
  std::string words;
  if (check.turns.difference() > kWorthAWord)
    words = turnsInWords(check.turns) + ": look at fx and fy of camera.ini";
  if (check.distances.difference() > kWorthAWord)
    words += (words.empty() ? "" : "; ") + distancesInWords(check.distances) +
             ": look at depth_scale of camera.ini and at the unit of the poses";
  if (!words.empty()) return words;
  const double axes = check.turns.certainAngleDeg(), directions = check.distances.certainAngleDeg();
  if (std::max(axes, directions) > kOtherAxisDeg)
    words = (axes > directions ? axesInWords(check.turns) : directionsInWords(check.distances)) +
            ": look at fx, fy, cx and cy of camera.ini; are the poses those of the depth camera?";
  return words;
}

bool isSenseless(const PoseDisagreement& d) {
  return d.rotation_deg > kSenselessDegrees || d.translation > kSenselessMetres;
}

Finding faultOf(const PoseCheck& check, const std::vector<Evidence>& evidence) {
  Finding found{check.convention.empty() ? "poses.disagree" : "poses.convention",
                check.isBeyondSense() ? Severity::refusal : Severity::doubt,
                "the poses disagree with the images by " + check.as_given.toString(), "", evidence};
  if (!check.cause.empty()) found.words += "; " + check.cause;
  if (check.mended.toString() != check.as_given.toString())
    found.words += "; so read, they disagree by " + check.mended.toString();
  if (!check.convention.empty())
    found.cure = "--poses-are " + check.convention + " reads them so";
  else if (check.isBeyondSense())
    found.cure = "--without-poses lets facetloc_map build find its own";
  return found;
}

/** The largest ones first. */
Finding outliersOf(const PoseCheck& check) {
  constexpr std::size_t kMostNamed = 5;
  std::vector<PoseOutlier> sorted = check.outliers;
  const auto cost = [](const PoseOutlier& o) { return Error{o.rotation_deg, o.translation}.cost(); };
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const PoseOutlier& a, const PoseOutlier& b) { return cost(a) > cost(b); });
  std::vector<std::string> named;
  for (std::size_t i = 0; i < std::min(sorted.size(), kMostNamed); ++i)
    named.push_back(fmt::format("between {:.3f} and {:.3f} s by {:.2f} m and {:.1f} deg", sorted[i].stamp_a,
                                sorted[i].stamp_b, sorted[i].translation, sorted[i].rotation_deg));
  if (sorted.size() > kMostNamed) named.push_back(fmt::format("and at {} more", sorted.size() - kMostNamed));
  const std::string words =
      fmt::format("single poses, or the motions that their images show, are beyond {:.0f} times the usual "
                  "disagreement: {}",
                  kOutlying, fmt::join(named, "; "));
  const std::vector<Evidence> evidence{{"outliers", static_cast<double>(sorted.size())},
                                       {"share", check.tail}};
  if (!check.hasTail()) return {"poses.outliers", Severity::note, words, "", evidence};
  return {"poses.outliers", Severity::doubt, words, "look at the poses at these times", evidence};
}

}  // namespace

std::string PoseDisagreement::toString() const {
  return fmt::format("{:.2f} deg, {:.0f} mm, median of {} motions", rotation_deg, 1e3 * translation, motions);
}

std::vector<std::string> PoseCheck::ratiosInWords() const {
  std::vector<std::string> words;
  if (turns.differs()) words.push_back(turnsInWords(turns));
  if (turns.certainAngleDeg() > 0) words.push_back(axesInWords(turns));
  if (distances.differs()) words.push_back(distancesInWords(distances));
  if (distances.certainAngleDeg() > 0) words.push_back(directionsInWords(distances));
  return words;
}

bool PoseCheck::isKnown() const { return std::max(as_given.motions, mended.motions) >= kEnough; }

bool PoseCheck::isBeyondSense() const {
  if (!isKnown()) return false;
  if (wrong_convention || as_given.motions < kEnough) return true;
  return as_given.motions >= kEnoughToRefuse && isSenseless(as_given);
}

bool PoseCheck::hasTail() const {
  constexpr std::size_t kSeveral = 3;
  return tail > kMostTail && tail * static_cast<double>(as_given.motions) >= kSeveral;
}

Findings PoseCheck::list() const {
  if (!isKnown())
    return {{"poses.unchecked", Severity::note,
             fmt::format("the poses could not be checked: of {} motions that the images show, poses "
                         "are known at both ends, and {} are needed",
                         as_given.motions, kEnough),
             ""}};
  Findings found;
  const std::vector<Evidence> evidence = {{"rotation_deg", as_given.rotation_deg},
                                          {"translation_m", as_given.translation},
                                          {"motions", static_cast<double>(as_given.motions)}};
  if (cause.empty() && !isBeyondSense())
    found.push_back({"poses.accuracy", Severity::note, "poses and images disagree by " + as_given.toString(),
                     "", evidence});
  else
    found.push_back(faultOf(*this, evidence));
  if (!outliers.empty()) found.push_back(outliersOf(*this));
  return found;
}

bool PoseJump::isTooFast() const {
  constexpr double kFastest = 3, kFastestTurn = 2 * M_PI;  // [m/s, rad/s]
  const double seconds = stamp_b - stamp_a;
  return timed && (by_poses.translation().norm() > kFastest * seconds ||
                   rotationAngle(by_poses.linear()) > kFastestTurn * seconds);
}

Finding PoseJump::finding() const {
  const auto words = [](const Eigen::Isometry3d& T) {
    return fmt::format("{:.2f} m and {:.0f} deg", T.translation().norm(),
                       rotationAngle(T.linear()) / kDegree);
  };
  return {
      "poses.jump",
      by_images && isTooFast() ? Severity::refusal : Severity::doubt,
      fmt::format("the poses jump, or begin anew, between {:.3f} and {:.3f} s: by {}, where the images {}",
                  stamp_a, stamp_b, words(by_poses),
                  by_images ? "move by " + words(*by_images) : "show nothing in common"),
      "make recordings of the parts before and after it, or let facetloc_map build --without-poses find its "
      "own",
      {{"jump_m", by_poses.translation().norm()},
       {"jump_deg", rotationAngle(by_poses.linear()) / kDegree},
       {"seconds", stamp_b - stamp_a}}};
}

PoseCheck internal::checkPoses(const std::vector<SeenMotion>& motions, const PosesByTime& poses) {
  const Trial trial(motions, poses);
  PoseCheck check;
  check.as_given = check.mended = disagreementOf(trial.pairs({}));
  compareLengths(motions, poses, check);
  findOutliers(motions, poses, check);
  const std::string of_lengths = faultOfLengths(check);
  const bool fine = of_lengths.empty() && !check.hasTail() && check.as_given.motions >= kEnough &&
                    check.as_given.rotation_deg <= kFineDegrees && check.as_given.translation <= kFineMetres;
  if (fine || motions.size() < kEnough) return check;
  const Reading best = trial.withBestDelay(trial.withBestScale(trial.bestConvention()));
  const PoseDisagreement mended = disagreementOf(trial.pairs(best));
  const bool explained = !isSenseless(mended);  // some reading always fits best, even poses of other images
  if (explained) {
    check.cause = toString(best);
    check.convention = conventionOf(best);
    check.wrong_convention = best.w_first || best.inverse || best.axes != Axes::optical ||
                             !best.storing.isUsual() ||
                             std::max(best.scale, 1 / best.scale) > 1 + kSenselessRatio;
  }
  if (check.cause.empty() && of_lengths.empty() && check.as_given.motions >= kEnoughToRefuse &&
      (check.as_given.rotation_deg > kFarDegrees || check.as_given.translation > kFarMetres))
    check.cause = "no scale and no convention explains it: look at fx, fy, cx and cy of camera.ini, and at "
                  "how accurate the poses are";
  if (check.cause.empty()) {
    check.cause = of_lengths;
    check.wrong_convention =
        std::max(check.turns.difference(), check.distances.difference()) > kSenselessRatio;
  }
  if (explained) check.mended = mended;
  return check;
}

}  // namespace facetloc
