// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/gravity.h>

#include <cmath>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr double kLeastStd = 0.001 * kDegree, kMostStd = 90 * kDegree;

bool isPossible(double std) { return std >= kLeastStd && std <= kMostStd; }

}  // namespace

bool Gravity::valid() const {
  constexpr double kUnit = 1e-6;
  return down.allFinite() && std::abs(down.norm() - 1) <= kUnit && isPossible(std);
}

Gravity gravityAlong(const Eigen::Vector3d& vector, double std) {
  constexpr double kLeastNorm =
      1e-3;  // least norm of directions, of g and of m/s^2: free fall has no direction
  if (!vector.allFinite()) throw std::invalid_argument("its gravity is not finite");
  const double norm = vector.stableNorm();
  if (!(norm >= kLeastNorm) || !std::isfinite(norm))
    throw std::invalid_argument("its gravity has no direction");
  if (!isPossible(std))
    throw std::invalid_argument("the standard deviation of gravity must lie in [0.001, 90] deg");
  return {vector / norm, std};
}

Eigen::Matrix3d levelling(const Eigen::Vector3d& down) {
  constexpr double kSteep = 0.2588;  // sine of 15 deg: about straight up or down, an axis has no heading
  const auto level = [&down](const Eigen::Vector3d& v) -> Eigen::Vector3d { return v - down.dot(v) * down; };
  Eigen::Vector3d ahead = level(Eigen::Vector3d::UnitZ());
  if (ahead.norm() < kSteep) ahead = level((down.z() > 0 ? -1 : 1) * Eigen::Vector3d::UnitY());
  ahead.normalize();
  Eigen::Matrix3d R;
  R.row(0) = down.cross(ahead);
  R.row(1) = down;
  R.row(2) = ahead;
  return R;
}

}  // namespace facetloc
