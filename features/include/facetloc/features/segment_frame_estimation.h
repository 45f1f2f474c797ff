// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/organized_cloud.h>
#include <facetloc/features/segment_estimation.h>
#include <facetloc/features/segment_frame.h>

#include <pcl/pcl_base.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A label of a cloud that is no segment. */
struct LeftOutLabel {
  std::uint32_t label = 0;
  std::string reason;  ///< such as "is seen edge-on"
};
/** \brief "3 of 18 labels are no segments: 2, 7 (is seen edge-on); 11 (is too narrow)"; empty if none is left
 * out. */
std::string toString(const std::vector<LeftOutLabel>& left_out, std::size_t labels);

/** \brief Segment frames of a labelled cloud, in PCL's feature vocabulary.
 *
 *     facetloc::SegmentFrameEstimation<pcl::PointXYZ> estimation;
 *     estimation.setInputCloud(cloud);
 *     estimation.setLabels(labels);     // made by PlanarSegmentation, or any other segmenter
 *     estimation.compute(frames);       // frames[i] is the segment of label estimation.usedLabels()[i]
 *
 * Derived from PCLBase, since pcl::Feature is made for one feature per point. Indices restrict the supporting
 * points. A cloud that is not organized, as after a filter, is seen from setViewpoint() (region_frame.h). Bad
 * data (no cloud, labels of another size) gives an empty output and a sentence in getReason(). Labels that
 * are too small, too narrow or seen edge-on are left out, and leftOut() lists them. */
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
  /** \brief Camera of the cloud: a Kinect-class one unless set. Without intrinsics these are
   * recovered from the points. Organized clouds that are noisier than its noise, or whose noise is smooth,
   * are measured to be so; for others it should be as in these very points. */
  void setCamera(const Camera& camera) { camera_ = camera; }
  const Camera& getCamera() const { return camera_; }

  /** \brief Where the camera was, in the coordinates of a cloud that is not organized [m]; their origin
   * unless set. */
  void setViewpoint(const Eigen::Vector3f& viewpoint) { viewpoint_ = viewpoint; }
  const Eigen::Vector3f& getViewpoint() const { return viewpoint_; }

  /** \brief Estimates the frames, the most informative segment first. */
  void compute(PointCloudOut& output);

  /** \brief The label of each frame of the last compute(). */
  const std::vector<std::uint32_t>& usedLabels() const { return used_labels_; }
  /** \brief The labels of the last compute() that are no segments, and why. */
  const std::vector<LeftOutLabel>& leftOut() const { return left_out_; }
  /** \brief Noise of the last cloud, by which the frames were estimated. */
  const SensorNoise& getNoise() const { return noise_; }
  /** \brief Why the last output is empty; empty if all went well. */
  const std::string& getReason() const { return status_; }

private:
  static bool isLabel(std::uint32_t label) {
    return label != 0 && label != std::numeric_limits<std::uint32_t>::max();
  }

  bool readLabels(std::vector<std::uint32_t>& given);
  std::vector<Segment> ofImage(DepthImage image, const std::vector<std::uint32_t>& given);
  std::vector<Segment> ofRegions(const std::vector<std::uint32_t>& given);

  using pcl::PCLBase<PointT>::input_;
  using pcl::PCLBase<PointT>::indices_;

  pcl::PointCloud<pcl::Label>::ConstPtr labels_;
  Camera camera_;
  SegmentEstimationParams params_;
  Eigen::Vector3f viewpoint_ = Eigen::Vector3f::Zero();
  std::vector<std::uint32_t> used_labels_;
  std::vector<LeftOutLabel> left_out_;
  SensorNoise noise_;
  std::string status_;
};

}  // namespace facetloc

#include <facetloc/features/impl/segment_frame_estimation.hpp>

extern template class facetloc::SegmentFrameEstimation<pcl::PointXYZ>;
extern template class facetloc::SegmentFrameEstimation<pcl::PointXYZI>;
extern template class facetloc::SegmentFrameEstimation<pcl::PointXYZRGB>;
extern template class facetloc::SegmentFrameEstimation<pcl::PointXYZRGBA>;
