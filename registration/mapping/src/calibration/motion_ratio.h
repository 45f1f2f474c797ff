// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/mapping/map_findings.h>

#include <Eigen/Core>

#include <vector>

namespace facetloc::internal {

/** \brief The same motion by two witnesses: translations, or rotation vectors, in the same axes. */
struct MotionVectors {
  Eigen::Vector3d by_images, by_poses;
  double start = 0;  ///< stamp of its first image: motions from the same image share their errors [s]
};

/** \brief Length of motions by images, relative to those by poses. Wrong motions among them are left out;
 * errors of either witness, however large next to the motions, make the ratio less certain and not another
 * one. Nothing is known of fewer than 5 motions. */
MotionRatio motionRatio(std::vector<MotionVectors> motions);

}  // namespace facetloc::internal
