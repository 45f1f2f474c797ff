// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/finding.h>
#include <facetloc/io/depth_sequence.h>

#include <optional>
#include <vector>

namespace facetloc {

/** \brief Why no depth camera can have these intrinsics; nothing if one can, and for none: the optical axis
 * leaves the image away from its border, and the field of view is below 150 deg. */
std::optional<Finding> opticsFinding(const Intrinsics& camera);

/** \brief The tests of values that need no file, on frames of a camera: the scale of their depths, images
 * that show one value or repeat, depth buffers, inverted depths, and limits stored as depths. \param images
 * valid ones \param max_depth of their camera [m] */
Findings depthFindings(const std::vector<DepthImage>& images, double max_depth);

/** \brief Findings of reading a sequence: its remarks, and the tests of its camera and of its values.
 * Reads up to 16 images. */
Findings readingFindings(const DepthSequence& sequence);

}  // namespace facetloc
