// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/local_model.h>
#include <facetloc/features/segment_estimation.h>
#include <facetloc/segmentation/plane_segmenter.h>

#include <pcl/types.h>

#include <memory>
#include <optional>
#include <string>

namespace pcl {
template <typename PointT>
class PointCloud;
}

namespace facetloc {

/** \brief Parameters of the way from a depth image to a view. The smallest support of a segment is
 * the labels'. */
struct ViewParams : SegmentationParams {
  static constexpr const char* kTitle = "From a depth image to its segments";
  SegmentEstimationParams features;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    SegmentationParams::describe(p, visit);
    visit("features", p.features);
  }
};

/** \brief Depth image or organized cloud -> view: working width, the camera's range and distortion,
 * segmentation, features, small depth picture, gravity. A view is complete: nothing is added to it later.
 *
 *     facetloc::ViewBuilder builder(map->calibrated(camera));  // to localize the view in a map
 *     const facetloc::View view = builder.build(image);
 *
 * The view knows its camera and the noise that it was seen with. Keeps its buffers; one per thread. */
class ViewBuilder {
public:
  /** \brief Throws std::invalid_argument for a parameter out of its range.
   * \param working_width larger images are thinned to about that many columns (workingImage()); 0 = none */
  explicit ViewBuilder(const Camera& camera = {}, const ViewParams& params = {}, int working_width = 0);

  /** \brief An empty or all-invalid image gives a view without segments, never an error. */
  View build(const DepthImage& image, const std::optional<Gravity>& gravity = {});
  /** \brief The view of an organized cloud, of which indices are seen; null = all. Needs
   * impl/view_builder.hpp. Nothing, with the reason, for a cloud that is no depth image. */
  template <typename PointT>
  std::optional<View> build(const pcl::PointCloud<PointT>* cloud, const pcl::Indices* indices,
                            std::string& why_not, const std::optional<Gravity>& gravity = {});
  /** \brief The same, in the memory that a view has: nothing is allocated once the builder and the view have
   * held an image as complex. */
  void build(const DepthImage& image, View& view);

  /** \brief The segmentation of the last image, its labels renumbered: label k is segment k - 1 of the view.
   */
  const LabelledPlanes& segmentation() const { return segmentation_; }
  const Camera& camera() const { return *camera_; }
  double segmentMilliseconds() const { return segment_ms_; }    ///< time for the last image
  double featuresMilliseconds() const { return features_ms_; }  ///< time for the last image

private:
  const DepthImage& prepared(const DepthImage& measured);
  void renumber();

  std::shared_ptr<const Camera> camera_;
  std::optional<DepthCorrection> correction_;
  DepthImage small_, near_;  // the image at the working width, and up to the camera's max_depth
  PlaneSegmenter segmenter_;
  SegmentEstimation estimation_;
  int working_width_;
  LabelledPlanes segmentation_, unsorted_;
  std::vector<int> kept_;
  std::vector<std::uint16_t> new_label_;
  double segment_ms_ = 0;
  double features_ms_ = 0;
};

}  // namespace facetloc
