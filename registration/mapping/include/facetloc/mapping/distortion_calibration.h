// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_distortion.h>
#include <facetloc/features/depth_picture.h>

#include <optional>
#include <vector>

namespace facetloc {

/** \brief How well the poses of pictures are known, relative to others nearby. */
struct PoseAccuracy {
  double rotation_std;     ///< about each axis [rad]
  double translation_std;  ///< along each axis [m]
};

/** \brief What pictures with poses tell of their camera. */
struct DistortionEstimate {
  DepthDistortion distortion;
  PoseAccuracy poses;  ///< by what the pictures show

  /** \brief Are the poses good enough? A distortion of one disparity unit of a Kinect tilts a wall at 3 m by
   * about half a degree. Poses that are worse than that, or that were themselves found with the distorted
   * images, cannot tell one from the other. */
  bool reliable() const;
};

/** \brief Finds the smooth distortion of a depth camera from pictures that it took of one place, from poses
 * that are known about: what it sees at one place of its image, it also sees at another, and the two differ.
 *
 * A pixel of one picture, moved into another, differs there by the distortion of both and by the error of the
 * pictures' poses. All differences of all overlapping pairs together are linear in the nodes of the field and
 * in six numbers per pair, which are eliminated. The field's prior is a Gaussian process whose variance is
 * the distortion that `noise` expects, so that what no pair tells of
 * stays 0; the variance of the poses is found along with their errors (expectation maximization).
 *
 * \param pictures of one camera, uncorrected
 * \param noise of that camera: random error and expected distortion
 * \param poses first guess of their accuracy
 * \return nothing if no two pictures show the same, or they are of several cameras. */
std::optional<DistortionEstimate> calibrateDistortion(const std::vector<PosedPicture>& pictures,
                                                      const SensorNoise& noise, const PoseAccuracy& poses);

}  // namespace facetloc
