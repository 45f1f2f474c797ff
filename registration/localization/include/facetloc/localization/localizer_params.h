// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/motion_params.h>

namespace facetloc {

/** \brief How the views of a moving camera together tell where it is. */
struct LocalizerParams {
  static constexpr const char* kTitle = "Localization of a moving camera";
  ViewOdometryParams odometry;  ///< odometry by images in quick succession
  double look_distance = 0.15;
  double look_rotation_deg = 5;
  int max_places = 12;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("odometry", p.odometry);
    visit("look_distance", p.look_distance, 0.0, 100.0,
          "Distance travelled after which a view is localized in the map again [m].", kForUsers);
    visit("look_rotation_deg", p.look_rotation_deg, 0.0, 180.0,
          "Rotation after which a view is localized in the map again [deg].", kForUsers);
    visit("max_places", p.max_places, 1, 1000, "Number of possible places of the camera that are kept.");
  }
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
