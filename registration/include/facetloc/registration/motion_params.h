// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>

namespace facetloc {

/** \brief How a camera moves from view to view, and which of its views are kept as keyframes. */
struct ViewOdometryParams {
  static constexpr const char* kTitle = "Motion of the camera from view to view";
  double key_distance = 0.3;
  double key_rotation_deg = 12;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("key_distance", p.key_distance, 0.0, 100.0,
          "Distance from all keyframes at which a new one is taken [m].");
    visit("key_rotation_deg", p.key_rotation_deg, 0.0, 180.0,
          "Rotation from all keyframes at which a new one is taken [deg].");
  }
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
