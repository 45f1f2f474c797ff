// SPDX-License-Identifier: BSD-3-Clause
#include "results/pose_columns.h"

#include <facetloc/io/atomic_file.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

constexpr double kStampRounding = 1e-6;  // [s] stamps are written with 6 decimals
constexpr double kWidestGap = 5;         // between poses to interpolate, by the tolerance

}  // namespace

Trajectory::Trajectory(std::vector<StampedPose> poses) : poses_(std::move(poses)) {
  std::stable_sort(poses_.begin(), poses_.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
}

Trajectory::Poses::const_iterator Trajectory::notBefore(double stamp) const {
  return std::lower_bound(poses_.begin(), poses_.end(), stamp,
                          [](const StampedPose& p, double s) { return p.stamp < s; });
}

std::optional<Eigen::Isometry3d> Trajectory::at(double stamp, double tolerance) const {
  const auto after = notBefore(stamp);
  const bool is_between = after != poses_.begin() && after != poses_.end() &&
                          after->stamp - after[-1].stamp <= kWidestGap * tolerance + kStampRounding;
  return is_between ? interpolated(stamp) : nearest(stamp, tolerance);
}

std::optional<Eigen::Isometry3d> Trajectory::nearest(double stamp, double tolerance) const {
  const auto distance = [stamp](const StampedPose& p) { return std::abs(p.stamp - stamp); };
  auto best = notBefore(stamp);
  if (best == poses_.end() || (best != poses_.begin() && distance(best[-1]) <= distance(*best))) {
    if (best == poses_.begin()) return {};
    --best;
  }
  if (!(distance(*best) <= tolerance + kStampRounding)) return {};
  return best->T_w_c;
}

std::optional<Eigen::Isometry3d> Trajectory::interpolated(double stamp) const {
  const auto after = notBefore(stamp);
  if (after == poses_.end()) return {};
  if (after->stamp == stamp) return after->T_w_c;
  if (after == poses_.begin()) return {};
  const StampedPose &a = after[-1], &b = *after;
  const double share = (stamp - a.stamp) / (b.stamp - a.stamp);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(a.T_w_c.linear())
                   .slerp(share, Eigen::Quaterniond(b.T_w_c.linear()))
                   .normalized()
                   .toRotationMatrix();
  T.translation() = (1 - share) * a.T_w_c.translation() + share * b.T_w_c.translation();
  return T;
}

void writeTumTrajectory(const std::filesystem::path& path, const std::vector<StampedPose>& poses) {
  writeTextAtomically(path, [&](std::ostream& out) {
    out << tum::kHeader;
    for (const StampedPose& pose : poses) out << tum::line(pose);
  });
}

}  // namespace facetloc
