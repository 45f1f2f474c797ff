// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief Errors of the poses that a map is made with: smooth along the way of the camera, so that
 * neighbouring images agree and a place that is passed again is somewhere else. */
struct MapPoseErrors {
  static constexpr const char* kTitle = "Errors of the poses of a mapping run";
  double translation_std = 0;   ///< along each axis [m]
  double rotation_std_deg = 0;  ///< about each axis
  double length = 3;            ///< shortest wavelength along the way [m]; the longest is three times that

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("translation_std", p.translation_std, 0.0, 10.0,
          "Error of positions along each axis, standard deviation [m].");
    visit("rotation_std_deg", p.rotation_std_deg, 0.0, 90.0,
          "Error of orientations about each axis, standard deviation [deg].");
    visit("length", p.length, 0.1, 1e4,
          "Path length of the camera over which the errors change [m]; a radian counts as a metre.");
  }
  void validate() const { checkRanges(*this); }
  bool any() const { return translation_std > 0 || rotation_std_deg > 0; }
};

/** \brief True poses T_w_c with such errors. Same seed, same errors. */
std::vector<Eigen::Isometry3d> simulateMapPoses(const std::vector<Eigen::Isometry3d>& T_w_c,
                                                const MapPoseErrors& errors, std::uint64_t seed);

}  // namespace facetloc
