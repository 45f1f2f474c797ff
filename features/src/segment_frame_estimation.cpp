// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/segment_frame_estimation.h>

namespace facetloc {
template std::optional<Intrinsics> recoverIntrinsics(const pcl::PointCloud<pcl::PointXYZ>&);
template std::optional<Intrinsics> recoverIntrinsics(const pcl::PointCloud<pcl::PointXYZI>&);
template std::optional<Intrinsics> recoverIntrinsics(const pcl::PointCloud<pcl::PointXYZRGB>&);
template std::optional<Intrinsics> recoverIntrinsics(const pcl::PointCloud<pcl::PointXYZRGBA>&);
template DepthImage depthImage(const pcl::PointCloud<pcl::PointXYZ>&, const Intrinsics&);
template DepthImage depthImage(const pcl::PointCloud<pcl::PointXYZI>&, const Intrinsics&);
template DepthImage depthImage(const pcl::PointCloud<pcl::PointXYZRGB>&, const Intrinsics&);
template DepthImage depthImage(const pcl::PointCloud<pcl::PointXYZRGBA>&, const Intrinsics&);
}  // namespace facetloc

template class facetloc::SegmentFrameEstimation<pcl::PointXYZ>;
template class facetloc::SegmentFrameEstimation<pcl::PointXYZI>;
template class facetloc::SegmentFrameEstimation<pcl::PointXYZRGB>;
template class facetloc::SegmentFrameEstimation<pcl::PointXYZRGBA>;
