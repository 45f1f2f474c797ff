// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/segmentation/depth_triangulation.h>
#include <facetloc/segmentation/region_merging.h>

namespace facetloc {

/** \brief Parameters of the whole segmentation; tolerances are multiples of the noise. */
struct SegmentationParams {
  DepthTriangulationParams split;
  RegionMergingParams merge;
  double label_tolerance = 5.0;  ///< largest residual of a labelled pixel [noise std]
  double min_support = 150;      ///< smallest segment [px at 320x240], scaled with the image area
  bool estimate_noise = true;    ///< raise the configured noise to what the image shows

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    DepthTriangulationParams::describe(p.split, field);
    RegionMergingParams::describe(p.merge, field);
    field("label_tolerance", p.label_tolerance, 1.0, 1e3,
          "Largest residual of a labelled pixel [noise standard deviations].");
    field("min_segment", p.min_support, 3.0, 1e6,
          "Smallest labelled region [px at 320x240, scaled with the image area]; see min_support.");
    field("estimate_noise", p.estimate_noise, false, true,
          "Raise the configured noise to what the image itself shows.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Labels of a depth image and the plane of each label. */
struct LabelledPlanes {
  Intrinsics camera;               ///< of the image
  LabelImage labels;               ///< labels count from 1 in the order of decreasing support
  std::vector<PixelPlane> planes;  ///< planes[k - 1] of label k, in inverse depth [1/m]
  std::vector<int> support;        ///< labelled pixels of label k
  double noise = 0;                ///< inverse-depth noise that the tolerances referred to [1/m]
};

/** \brief Cuts depth images into planar surface segments: split, merge, label, hand over boundary pixels.
 *
 * The PCL-free core of PlanarSegmentation. Keeps its buffers between images; use one per thread. */
class PlaneSegmenter {
public:
  explicit PlaneSegmenter(const SegmentationParams& params = {}, const SensorNoise& noise = {});

  /** \brief Segments an image; an empty or all-invalid image gives no labels, never an error. */
  void segment(const DepthImage& image, LabelledPlanes& out);

private:
  struct Pixel {
    std::int32_t u, v;
  };
  void label(LabelledPlanes& out);
  void reassignBoundaries(LabelImage& labels);
  void keepLargeRegions(LabelledPlanes& out, double min_support);

  SegmentationParams params_;
  SensorNoise noise_;
  DisparityImage disparity_;
  DepthTriangulation split_;
  RegionMerging merge_;
  std::vector<PixelPlane> region_planes_;  // by provisional label, in units of the disparity image
  std::vector<int> support_;               // of it [px]
  std::vector<std::uint16_t> label_of_region_, order_;
  std::vector<std::int32_t> columns_;  // of a row, and room for one more
  std::vector<Pixel> front_;
  std::vector<float> scratch_;
};

}  // namespace facetloc
