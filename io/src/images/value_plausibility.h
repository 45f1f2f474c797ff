// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/finding.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace facetloc::internal {

/** \brief An image for findings on its values. */
struct ValueImage {
  DepthImage depth;        ///< as stored, at the working width, without max_depth
  bool stretched = false;  ///< to the range of its format
  std::vector<float> measured;
};

/** \brief The numbers of up to 16 images of a sequence, in its order. */
std::vector<std::size_t> valueSample(const DepthSequence& sequence);

/** \brief Some images of a sequence, each read once for all findings on their values. */
class ValueSample {
public:
  /** \brief Images that cannot be read are left out. \param take receives the values of each PNG */
  ValueSample(const DepthSequence& sequence, const std::function<void(const Raster<std::uint16_t>&)>& take);

  /** \brief Findings on the depths, whatever their format, that no calibration explains: one value
   * everywhere, the same image again, images stretched to the range of their format, depth buffers, depths
   * that grow towards the camera, and limits stored as depths. */
  Findings findings() const;

private:
  static ValueImage read(const DepthSequence& sequence, std::size_t index,
                         const std::function<void(const Raster<std::uint16_t>&)>& take);

  double max_depth_;
  std::vector<ValueImage> images_;
};

/** \brief The same findings on images that are in memory, whose format is not known. */
Findings valueFindings(const std::vector<DepthImage>& images, double max_depth);

}  // namespace facetloc::internal
