// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>
#include <facetloc/mapping/map_findings.h>
#include <facetloc/mapping/map_image.h>

#include <vector>

namespace facetloc::internal {

/** \brief How a camera moved between two images, by the images themselves. */
struct SeenMotion {
  double stamp_a = 0, stamp_b = 0;                          ///< [s]
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< pose of the second camera in the first
};

/** \brief Compares poses with the motion between images, and if they disagree, tries common faults of
 * poses: quaternions in the order w x y z; the inverse; the axes of a robot's body (x forward, z
 * up) or of OpenGL (z backward, y up); another clock; another scale, of the poses or of depth; a wrong
 * focal length. A fault is named if without it the disagreement is less than half as large. \param
 * motions of which some may be wrong */
PoseCheck checkPoses(const std::vector<SeenMotion>& motions, const PosesByTime& poses);

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
