// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/motion_params.h>
#include <facetloc/registration/pose_prior.h>

namespace facetloc {

/** \brief How the trajectory of a camera is found from its images alone, and its way back to known places. */
struct MappingParams {
  static constexpr const char* kTitle = "Trajectory of a camera by its images";
  ViewOdometryParams odometry;
  OdometryError odometry_error;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("odometry", p.odometry);
    visit("odometry_error", p.odometry_error);
  }
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
