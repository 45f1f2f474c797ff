// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"
#include "bytes/plausible.h"

#include <facetloc/io/trajectory.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace facetloc {

/** \brief A pose as our files and tables have it: tx ty tz qx qy qz qw, with qw >= 0. */
using PoseColumns = std::array<double, 7>;

inline PoseColumns toColumns(const Eigen::Isometry3d& T) {
  Eigen::Quaterniond q = Eigen::Quaterniond(T.linear()).normalized();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const auto& t = T.translation();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

/** \brief The fault of a pose; null if it is sound. \param tolerance of |q|^2, which is 1 */
inline const char* faultOf(const PoseColumns& c, double tolerance) {
  if (!std::all_of(c.begin(), c.end(), [](double x) { return std::isfinite(x); })) return "is not finite";
  if (!plausible::isPosition({c[0], c[1], c[2]})) return "is more than 1000 km away";
  const Eigen::Quaterniond q(c[6], c[3], c[4], c[5]);
  return std::abs(q.squaredNorm() - 1) <= tolerance ? nullptr : "is not a rotation";
}

/** \brief Throws std::invalid_argument if it has a fault. */
inline Eigen::Isometry3d fromColumns(const PoseColumns& c, double tolerance) {
  if (const char* fault = faultOf(c, tolerance))
    throw std::invalid_argument(std::string("its pose ") + fault);
  const Eigen::Quaterniond q(c[6], c[3], c[4], c[5]);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() << c[0], c[1], c[2];
  return T;
}

/** Lines of trajectories in the TUM format. */
namespace tum {

constexpr const char* kHeader = "# timestamp tx ty tz qx qy qz qw\n";
constexpr int kStampDecimals = 6;

/** \brief Throws std::invalid_argument for a pose that is not finite. */
inline std::string line(const StampedPose& pose) {
  if (!std::isfinite(pose.stamp) || !pose.T_w_c.matrix().allFinite())
    throw std::invalid_argument("a pose of the trajectory is not finite");
  std::string out = text::decimals(pose.stamp, kStampDecimals);
  for (const double value : toColumns(pose.T_w_c)) out.append(" ").append(text::significant(value));
  return out + "\n";
}

}  // namespace tum
}  // namespace facetloc
