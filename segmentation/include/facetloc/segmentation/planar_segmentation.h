// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/organized_cloud.h>
#include <facetloc/segmentation/plane_segmenter.h>
#include <facetloc/segmentation/segmentation.h>

#include <optional>

namespace facetloc {

/** \brief Cuts clouds into planar surface segments: the pcl::Segmentation of PlaneSegmenter.
 *
 *     facetloc::PlanarSegmentation<pcl::PointXYZRGBA> segmentation;
 *     segmentation.setInputCloud(cloud);
 *     std::vector<pcl::PointIndices> segments;
 *     std::vector<pcl::ModelCoefficients> planes;
 *     segmentation.segment(segments, planes);
 *
 * NaN and zero depth are the normal case. Normals point towards the origin of the coordinates, where the
 * camera must be; the cloud's sensor_origin_ says where that is in the world and does not matter. Indices
 * restrict the points that are looked at to a part of the image; they are no sample. A cloud that is not
 * organized, as after a filter, needs a camera with intrinsics (setCamera). Keeps its buffers from cloud to
 * cloud. */
template <typename PointT>
class PlanarSegmentation : public pcl::Segmentation<PointT> {
public:
  using Ptr = pcl::shared_ptr<PlanarSegmentation<PointT>>;
  using ConstPtr = pcl::shared_ptr<const PlanarSegmentation<PointT>>;
  using Labels = pcl::PointCloud<pcl::Label>;

  void setParams(const SegmentationParams& params) {
    params_ = checked(params);
    segmenter_.reset();
  }
  const SegmentationParams& getParams() const { return params_; }
  /** \brief Camera of the clouds: a Kinect-class one unless set. Without intrinsics these are
   * recovered from the points; mounting and distortion do not matter here. */
  void setCamera(const Camera& camera) {
    camera_ = camera;
    segmenter_.reset();
  }
  const Camera& getCamera() const { return camera_; }
  /** \brief Smallest segment [points at 320x240, scaled with the size of the cloud]. */
  void setMinInliers(unsigned n) {
    params_.labels.min_support = n;
    segmenter_.reset();
  }
  unsigned getMinInliers() const { return static_cast<unsigned>(params_.labels.min_support); }

  void segment(std::vector<pcl::PointIndices>& segments) override;
  void segment(std::vector<pcl::PointIndices>& segments,
               std::vector<pcl::ModelCoefficients>& coefficients) override;
  /** \brief One label per point, 0 = none, k = k-th segment. */
  void segment(Labels& labels);

  /** \brief The segmentation behind the last call; empty after a failed one. */
  const LabelledPlanes& getSegmentation() const { return result_; }
  std::string getClassName() const override { return "PlanarSegmentation"; }

private:
  using pcl::PCLBase<PointT>::input_;
  using pcl::PCLBase<PointT>::indices_;
  using pcl::Segmentation<PointT>::status_;

  bool compute();
  int labelOf(std::size_t point) const;

  SegmentationParams params_;
  Camera camera_;
  std::optional<PlaneSegmenter> segmenter_;  // keeps its buffers
  LabelledPlanes result_;
};

}  // namespace facetloc

#include <facetloc/segmentation/impl/planar_segmentation.hpp>

extern template class facetloc::PlanarSegmentation<pcl::PointXYZ>;
extern template class facetloc::PlanarSegmentation<pcl::PointXYZI>;
extern template class facetloc::PlanarSegmentation<pcl::PointXYZRGB>;
extern template class facetloc::PlanarSegmentation<pcl::PointXYZRGBA>;
