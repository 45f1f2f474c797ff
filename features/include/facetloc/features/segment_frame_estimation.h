// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/organized_cloud.h>
#include <facetloc/features/segment_estimation.h>
#include <facetloc/features/segment_frame.h>

#include <pcl/pcl_base.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Segment frames of an organized, labelled cloud, in PCL's feature vocabulary.
 *
 *     facetloc::SegmentFrameEstimation<pcl::PointXYZ> estimation;
 *     estimation.setInputCloud(cloud);
 *     estimation.setLabels(labels);     // of PlanarSegmentation, or of any other segmenter
 *     estimation.compute(frames);       // frames[i] is the segment of label estimation.usedLabels()[i]
 *
 * Derived from PCLBase, since pcl::Feature is made for one feature per point. Indices restrict the supporting
 * points. Bad data (no cloud, unorganized, labels of another size) gives an empty output and a sentence in
 * getStatus(). */
template <typename PointT>
class SegmentFrameEstimation : public pcl::PCLBase<PointT> {
public:
  using Ptr = pcl::shared_ptr<SegmentFrameEstimation<PointT>>;
  using ConstPtr = pcl::shared_ptr<const SegmentFrameEstimation<PointT>>;
  using PointCloudOut = pcl::PointCloud<SegmentFrame>;

  /** \brief One label per point of the input cloud, row-major; 0 = none, and so is the largest number, which
   * PCL's segmenters give to points without a region. At most 65535 different ones. */
  void setLabels(const pcl::PointCloud<pcl::Label>::ConstPtr& labels) { labels_ = labels; }
  void setParams(const SegmentEstimationParams& params) { params_ = checked(params); }
  const SegmentEstimationParams& getParams() const { return params_; }
  /** \brief By which camera the cloud was seen: a Kinect-class one unless set. Without intrinsics these are
   * recovered from the points. Its noise should be as in these very points: images may be noisier than
   * their camera's specification, and a segmenter that estimates the noise tells it, PlanarSegmentation by
   * getSegmentation().noise. Too small a noise gives too small covariances. */
  void setCamera(const Camera& camera) { camera_ = camera; }
  const Camera& getCamera() const { return camera_; }

  /** \brief Estimates the frames, the most informative segment first. */
  void compute(PointCloudOut& output);

  /** \brief The label of each frame of the last compute(). */
  const std::vector<std::uint32_t>& usedLabels() const { return used_labels_; }
  /** \brief Why the last output is empty; empty if all went well. */
  const std::string& getStatus() const { return status_; }

private:
  static bool isLabel(std::uint32_t label) {
    return label != 0 && label != std::numeric_limits<std::uint32_t>::max();
  }

  using pcl::PCLBase<PointT>::input_;
  using pcl::PCLBase<PointT>::indices_;

  pcl::PointCloud<pcl::Label>::ConstPtr labels_;
  Camera camera_;
  SegmentEstimationParams params_;
  std::vector<std::uint32_t> used_labels_;
  std::string status_;
};

}  // namespace facetloc

#include <facetloc/features/impl/segment_frame_estimation.hpp>

extern template class facetloc::SegmentFrameEstimation<pcl::PointXYZ>;
extern template class facetloc::SegmentFrameEstimation<pcl::PointXYZI>;
extern template class facetloc::SegmentFrameEstimation<pcl::PointXYZRGB>;
extern template class facetloc::SegmentFrameEstimation<pcl::PointXYZRGBA>;
