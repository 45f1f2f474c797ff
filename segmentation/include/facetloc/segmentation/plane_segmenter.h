// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/plane_fit.h>
#include <facetloc/segmentation/segmentation_params.h>

#include <memory>
#include <vector>

namespace facetloc {

/** \brief Labels of a depth image and the plane of each label. */
struct LabelledPlanes {
  Intrinsics camera;               ///< intrinsics of the image
  LabelImage labels;               ///< labels count from 1 in the order of decreasing support
  std::vector<PixelPlane> planes;  ///< planes[k - 1] of label k, in inverse depth [1/m]
  std::vector<int> support;        ///< labelled pixels of label k
  double noise = 0;                ///< inverse-depth noise of the image [1/m]; tolerances are multiples of it
  double correlation_px = 0;       ///< over which pixels share it, if it is smooth; 0 = not [px at 320x240]
};

/** \brief Cuts depth images into planar surface segments: split, merge, label, hand over boundary pixels.
 *
 * The PCL-free core of PlanarSegmentation. Keeps its buffers between images; use one per thread. */
class PlaneSegmenter {
public:
  /** \param noise of the camera */
  explicit PlaneSegmenter(const SegmentationParams& params = {}, const SensorNoise& noise = {});
  PlaneSegmenter(const PlaneSegmenter& other);
  PlaneSegmenter& operator=(const PlaneSegmenter& other);
  PlaneSegmenter(PlaneSegmenter&&) noexcept;
  PlaneSegmenter& operator=(PlaneSegmenter&&) noexcept;
  ~PlaneSegmenter();

  /** \brief Segments an image; an empty or all-invalid image gives no labels, never an error. */
  void segment(const DepthImage& image, LabelledPlanes& out);

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facetloc
