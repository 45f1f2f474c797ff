// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/motion_params.h>

namespace facetloc {

/** \brief How the views of a moving camera together tell where it is. */
struct LocalizerParams {
  static constexpr const char* kTitle = "Localization of a moving camera";
  ViewOdometryParams odometry;  ///< of images in quick succession
  double look_distance = 0.15;
  double look_rotation_deg = 5;
  int max_places = 12;
  int kept_looks = 6;
  double most_log_odds = 7;
  double max_translation = 0.15;
  double max_rotation_deg = 3;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("odometry", p.odometry);
    visit("look_distance", p.look_distance, 0.0, 100.0,
          "Way of the camera after which its view is looked for in the map again [m].", kForUsers);
    visit("look_rotation_deg", p.look_rotation_deg, 0.0, 180.0,
          "Rotation of the camera after which its view is looked for in the map again [deg].", kForUsers);
    visit("max_places", p.max_places, 1, 1000, "Number of places where the camera may be that are kept.");
    visit("kept_looks", p.kept_looks, 0, 1000,
          "Number of latest views by which a place is judged that only a later one brings up.");
    visit("most_log_odds", p.most_log_odds, 0.1, 100.0,
          "Log odds that any number of views add up to at most; less forgets faster [nats].");
    visit("max_translation", p.max_translation, 1e-3, 100.0,
          "Position error that 95 % of the errors must stay below for a place to be sure, two standard "
          "deviations [m].",
          kForUsers);
    visit("max_rotation_deg", p.max_rotation_deg, 1e-3, 180.0,
          "Orientation error that 95 % of the errors must stay below for a place to be sure [deg].",
          kForUsers);
  }
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
