// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/answer_state.h>
#include <facetloc/registration/motion_params.h>
#include <facetloc/registration/pose_prior.h>

namespace facetloc {

/** \brief When a tracked place is believed, and when it is compared with the whole map. */
struct PoseTrackingParams {
  static constexpr const char* kTitle = "Tracking of a camera in a map";
  ViewOdometryParams odometry;
  OdometryError odometry_error;
  double check_interval = 2.0;
  double max_gap = 1.0;
  double min_probability = kMinProbability;  ///< of a place where tracking begins

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("odometry", p.odometry);
    visit("odometry_error", p.odometry_error);
    visit("check_interval", p.check_interval, 0.0, 1e6,
          "Time between two searches of the whole map while the place is in doubt [s].");
    visit("max_gap", p.max_gap, 1e-3, 1e6, "Longest time between two views of one track [s].");
  }
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
