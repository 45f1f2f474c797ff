// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/io/png.h>

#include <cstddef>
#include <cstdint>

namespace facetloc::benchmarks {

/** \brief How well segments respect objects, over one or more images.
 *
 * Labels of objects as in the mOSD clouds of PCL's data repository: 0 = not labelled, 1 to 19 = parts of the
 * table, 20 to 29 the first object on it, 30 to 39 the second, and so on. Faces of one object are one object
 * here: a segment across them is no error. */
struct ObjectScore {
  static constexpr std::size_t kMinPixels = 100;  ///< labelled pixels from which on a segment counts
  static constexpr double kOneObject = 0.9;       ///< share of a segment that has to be on one object

  std::size_t images = 0;
  std::size_t segments = 0;        ///< that count
  std::size_t across = 0;          ///< segments with less than kOneObject on one object
  std::size_t segment_pixels = 0;  ///< labelled pixels of the segments that count
  std::size_t main_pixels = 0;     ///< pixels on the segment's main object
  std::size_t object_pixels = 0;   ///< pixels with depth on objects, without the table
  std::size_t covered_pixels = 0;  ///< pixels in any segment

  ObjectScore& operator+=(const ObjectScore& other);
};

/** \brief 0 for pixels without a label, 1 for the table, 2 and up for the objects on it. */
int objectOf(std::uint16_t label);

/** \brief The score of one image; pixels without depth do not count. Throws std::invalid_argument if sizes
 * differ. */
ObjectScore objectScore(const LabelImage& found, const Raster<std::uint16_t>& truth, const DepthImage& depth);

}  // namespace facetloc::benchmarks
