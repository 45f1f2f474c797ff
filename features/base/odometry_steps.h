// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include <optional>
#include <utility>

namespace facetloc::internal {

/** \brief Motions from image to image by the poses of an odometry. */
class OdometrySteps {
public:
  /** \brief T_before_now since the pose before; nothing at the first one, and where one of the two is
   * unknown. */
  std::optional<Eigen::Isometry3d> to(const std::optional<Eigen::Isometry3d>& T_o_c) {
    const std::optional<Eigen::Isometry3d> before = std::exchange(T_o_before_, T_o_c);
    if (!before || !T_o_c) return {};
    return Eigen::Isometry3d(before->inverse() * *T_o_c);
  }
  /** \brief The next pose is as the first one. */
  void reset() { T_o_before_.reset(); }

private:
  std::optional<Eigen::Isometry3d> T_o_before_;
};

}  // namespace facetloc::internal
