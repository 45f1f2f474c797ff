// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/finding.h>
#include <facetloc/io/depth_sequence.h>

#include <cstddef>
#include <optional>
#include <vector>

namespace facetloc {

/** \brief Statistics of the raw values of depth PNGs: of pixels that are measured, and of pairs of
 * neighbours. */
struct DepthValues {
  std::size_t count = 0;               ///< number of measured pixels
  std::size_t different = 0;           ///< number of different values
  int divisor = 1;                     ///< largest number of which 98 % of the values are multiples
  double neighbours = 0;               ///< median difference of neighbouring pixels that differ
  double neighbours_swapped = 0;       ///< the same with the two bytes of each value swapped
  double median = 0;                   ///< median of the values
  std::vector<std::size_t> histogram;  ///< number of pixels by value, 65536 entries; empty without any
};

/** \brief Evidence in raw values of how they must be read. */
struct ValueCheck {
  DepthValues values;
  double median_depth = 0;      ///< [m]
  double share_beyond_10m = 0;  ///< share of the measured pixels
  Findings findings;
};

/** \brief Looks at the raw values of up to 16 PNGs of a sequence. Images of other formats, and those that
 * cannot be read, are left out. */
DepthValues depthValues(const DepthSequence& sequence);

/** \brief Judges values: swapped bytes, shifted bits, 8 bits in place of 16, a wrong depth_scale.
 * \param depth_scale values per metre */
ValueCheck checkValues(DepthValues values, double depth_scale);

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
