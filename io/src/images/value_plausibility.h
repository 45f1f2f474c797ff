// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/finding.h>
#include <facetloc/io/depth_sequence.h>

#include <vector>

namespace facetloc::internal {

/** \brief Findings on the depths of up to 16 images, whatever their format, that no calibration explains: one
 * value everywhere, the same image again, images stretched to the range of their format, depth buffers,
 * depths that grow towards the camera, and limits stored as depths. Images that cannot be read are left out.
 */
Findings valueFindings(const DepthSequence& sequence);
/** \brief The same on images that are in memory, whose format is not known. */
Findings valueFindings(const std::vector<DepthImage>& images, double max_depth);

}  // namespace facetloc::internal
