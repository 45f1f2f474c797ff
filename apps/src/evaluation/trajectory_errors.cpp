// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/trajectory_errors.h"

#include "base/text.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr double kRelativeTime = 1;      // [s]
constexpr double kRelativeDistance = 1;  // [m]
constexpr double kRelativeShare = 0.1;   // share of the whole distance
constexpr double kLongest = 2;           // longest interval, as a multiple of that: longer ones bridge a gap
constexpr double kRounding = 1e-9;

void requireDifferentStamps(const Trajectory& trajectory, const std::string& name) {
  const auto& poses = trajectory.poses();
  const auto same =
      std::adjacent_find(poses.begin(), poses.end(),
                         [](const StampedPose& a, const StampedPose& b) { return a.stamp == b.stamp; });
  if (same != poses.end())
    throw std::invalid_argument(
        fmt::format("two {} poses have the stamp {}", name, text::shortest(same->stamp)));
}

/** \param position of each pair on the axis along which intervals have the length */
std::optional<RelativeErrors> relativeErrors(const std::string& over, const TrajectoryErrors& errors,
                                             const std::vector<double>& position, double length) {
  RelativeErrors relative;
  relative.over = over;
  std::vector<double> translation, rotation_deg;
  std::size_t last = 0;
  for (std::size_t first = 0; first < errors.pairs.size(); ++first) {
    while (last < position.size() && position[last] < position[first] + length - kRounding) ++last;
    if (last == position.size()) break;
    if (position[last] > position[first] + kLongest * length) continue;
    const PosePair &a = errors.pairs[first], &b = errors.pairs[last];
    const Eigen::Isometry3d estimated = a.estimated.inverse() * b.estimated;
    const Eigen::Isometry3d difference = (a.truth.inverse() * b.truth).inverse() * estimated;
    translation.push_back(difference.translation().norm());
    rotation_deg.push_back(rotationAngle(difference.linear()) / kDegree);
    relative.mean_distance += errors.distance[last] - errors.distance[first];
  }
  if (translation.empty()) return {};
  relative.intervals = translation.size();
  relative.mean_distance /= static_cast<double>(relative.intervals);
  relative.translation = Sample(translation);
  relative.rotation_deg = Sample(rotation_deg);
  return relative;
}

void addRelativeErrors(TrajectoryErrors& errors) {
  std::vector<double> time;
  for (const PosePair& pair : errors.pairs) time.push_back(pair.stamp);
  const auto add = [&](const std::string& over, const std::vector<double>& position, double length) {
    if (!(length > 0)) return;
    if (auto relative = relativeErrors(over, errors, position, length))
      errors.relative.push_back(std::move(*relative));
  };
  add(kOverSecond, time, kRelativeTime);
  add(kOverMetre, errors.distance, kRelativeDistance);
  add(kOverTenth, errors.distance, kRelativeShare * errors.length());
}

}  // namespace

TrajectoryErrors trajectoryErrors(const Trajectory& estimate, const Trajectory& truth, double tolerance) {
  requireDifferentStamps(estimate, "estimated");
  requireDifferentStamps(truth, "true");
  TrajectoryErrors errors;
  for (const StampedPose& pose : estimate.poses()) {
    if (const auto true_pose = truth.at(pose.stamp, tolerance))
      errors.pairs.push_back({pose.stamp, pose.T_w_c, *true_pose});
    else
      ++errors.without_truth;
  }
  errors.alignment = aligned(errors.pairs);
  double distance = 0;
  for (std::size_t i = 0; i < errors.pairs.size(); ++i) {
    PosePair& pair = errors.pairs[i];
    pair.estimated = errors.alignment.T_true_estimated * pair.estimated;
    if (i > 0) distance += (pair.truth.translation() - errors.pairs[i - 1].truth.translation()).norm();
    errors.distance.push_back(distance);
    errors.translation.push_back((pair.estimated.translation() - pair.truth.translation()).norm());
    errors.rotation_deg.push_back(rotationAngle(pair.estimated.linear().transpose() * pair.truth.linear()) /
                                  kDegree);
  }
  errors.absolute = Sample(errors.translation);
  errors.absolute_rotation_deg = Sample(errors.rotation_deg);
  addRelativeErrors(errors);
  return errors;
}

}  // namespace facetloc
