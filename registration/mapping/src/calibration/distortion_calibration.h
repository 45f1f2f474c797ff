// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_picture.h>
#include <facetloc/mapping/map_findings.h>

#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief Finds the smooth distortion of a depth camera from pictures that it took of one place, with
 * approximate poses: a surface appears at different places of its image, and the two measurements differ.
 *
 * A pixel of one picture, moved into another, differs there by the distortion of both and by the error of the
 * pictures' poses. All differences of all overlapping pairs together are linear in the nodes of the field and
 * in six numbers per pair, which are eliminated. The field's prior is a Gaussian process whose variance is
 * the distortion that `noise` expects, so that nodes without measurements
 * stay 0; the variance of the poses is found along with their errors (expectation maximization).
 *
 * \param pictures of one camera, uncorrected
 * \param noise of that camera: random error and expected distortion
 * \param poses first guess of their accuracy
 * \param threads 0 = all cores; the result is the same for any number
 * \return nothing if no two pictures show the same, or they are of several cameras. */
std::optional<DistortionEstimate> calibrateDistortion(const std::vector<PosedPicture>& pictures,
                                                      const SensorNoise& noise, const PoseAccuracy& poses,
                                                      int threads = 1);

}  // namespace facetloc::internal
