// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/params.h>
#include <facetloc/features/plane_fit.h>

#include <memory>
#include <vector>

namespace facetloc {

/** \brief The two ways to split an image: squares whose moments are known (METHOD 4), and the paper's
 * triangles (METHOD 3). */
enum class SplitMethod { quadtree, delaunay };
constexpr const char* kNamesOfSplitMethods[] = {"quadtree", "delaunay"};
constexpr const auto& namesOf(SplitMethod) { return kNamesOfSplitMethods; }

/** \brief Split stage: its elements, and the limit of flatness (METHOD 3.2). */
struct SplitParams {
  static constexpr const char* kTitle = "Split of a depth image into flat parts";
  SplitMethod method = SplitMethod::quadtree;
  double tolerance = 7.0;
  double min_area = 2;
  int max_vertices = 20000;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("method", p.method, SplitMethod::quadtree, SplitMethod::delaunay,
          "How an image is split: quadtree, into squares, is fast; delaunay, into triangles, is the paper's "
          "way. --split for short.",
          kForUsers);
    visit(
        "tolerance", p.tolerance, 1.0, 1e3,
        "Largest deviation of a pixel from the plane of its triangle [noise standard deviations]; 6 to 8 do "
        "well, more for a camera whose noise is smooth over many pixels.");
    visit("min_area", p.min_area, 0.0, 1e6,
          "Area up to which a triangle is not refined [px at 320x240, scaled with the image area].");
    visit("max_vertices", p.max_vertices, 4, 1000000,
          "Limit of the number of vertices; the worst triangles are refined first.");
  }
};

/** \brief Merge stage: when two regions, or the parts of a cell, are one plane (METHOD 5). */
struct MergeParams {
  static constexpr const char* kTitle = "Merging of regions into planes";
  double tolerance = 2.75;
  double min_plane_distance = 0.12;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("tolerance", p.tolerance, 0.1, 1e3,
          "Largest residual or displacement at which two regions are merged [noise standard deviations]; 2.5 "
          "to 3 "
          "do well, more for a camera whose noise is smooth over many pixels.");
    visit("min_plane_distance", p.min_plane_distance, 0.0, 10.0,
          "Distance from the camera centre below which the plane of a triangle or a square is a depth "
          "discontinuity [m].");
  }
};

/** \brief Labels of the pixels of each plane. */
struct LabelParams {
  static constexpr const char* kTitle = "Labels of the pixels of each plane";
  double tolerance = 5.0;
  double min_support = 150;
  bool estimate_noise = true;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("tolerance", p.tolerance, 1.0, 1e3,
          "Largest residual of a pixel that belongs to a plane [noise standard deviations].");
    visit("min_support", p.min_support, 3.0, 1e6,
          "Number of pixels of the smallest segment [px at 320x240, scaled with the image area].", kForUsers);
    visit("estimate_noise", p.estimate_noise, false, true,
          "Raise the camera's noise to that measured in each image.");
  }
};

/** \brief Parameters of the whole segmentation; tolerances are multiples of the noise. */
struct SegmentationParams {
  static constexpr const char* kTitle = "Segmentation";
  SplitParams split;
  MergeParams merge;
  LabelParams labels;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("split", p.split);
    visit("merge", p.merge);
    visit("labels", p.labels);
  }
};

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
