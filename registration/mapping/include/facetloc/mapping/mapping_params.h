// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/localization/tracking_params.h>

namespace facetloc {

/** \brief How the trajectory of a camera is found from its images alone, and its way back to known places. */
struct MappingParams {
  static constexpr const char* kTitle = "Trajectory of a camera by its images";
  ViewOdometryParams odometry;
  double min_agreement = 0.8;    ///< share of the depth pixels of two keyframes in which they must agree
  double reach = 1.5;            ///< distance of two keyframes that are compared [m]
  double reach_deg = 45;         ///< angle between the viewing directions of two keyframes that are compared
  int neighbours = 12;           ///< nearest earlier keyframes that each one is compared with
  double trusted_std = 0.3;      ///< of a relative position: beyond it, a lone loop is not believed [m]
  int consistent_loops = 3;      ///< that must agree before an uncertain one of them is believed
  int passes = 4;                ///< comparisons of all keyframes, each followed by an optimization
  double odometry_drift = 0.02;  ///< of a given odometry: error of the way, as a share of it
  double odometry_turn_deg = 1;  ///< of a given odometry: error of the heading after 1 m of way

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("odometry", p.odometry);
    visit("min_agreement", p.min_agreement, 0.0, 1.0,
          "Share of the depth pixels of two keyframes that must agree, or their motion is not believed.");
    visit("reach", p.reach, 0.01, 100.0, "Largest distance of two keyframes that are compared [m].");
    visit("reach_deg", p.reach_deg, 1.0, 180.0,
          "Largest angle between the viewing directions of two keyframes that are compared [deg].");
    visit("neighbours", p.neighbours, 1, 1000,
          "Number of nearest earlier keyframes that each keyframe is compared with.");
    visit(
        "trusted_std", p.trusted_std, 0.0, 100.0,
        "Uncertainty of the relative position of two keyframes beyond which a loop needs others that agree, "
        "standard deviation [m].");
    visit("consistent_loops", p.consistent_loops, 1, 100,
          "Number of loops that must agree with each other before an uncertain one of them is believed.");
    visit("passes", p.passes, 1, 100,
          "Number of comparisons of all keyframes, each followed by an optimization of all poses.");
    visit("odometry_drift", p.odometry_drift, 0.0, 1.0,
          "Error of a given odometry along its way, standard deviation as a share of the way.");
    visit("odometry_turn_deg", p.odometry_turn_deg, 0.0, 180.0,
          "Error of the heading of a given odometry after one metre of way, standard deviation [deg].");
  }
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
