// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/segment_frame_estimation.h>

#include <fmt/format.h>
#include <map>

namespace facetloc {

std::string toString(const std::vector<LeftOutLabel>& left_out, std::size_t labels) {
  if (left_out.empty()) return {};
  std::map<std::string, std::string> of_reason;
  for (const LeftOutLabel& l : left_out) {
    std::string& list = of_reason[l.reason];
    list += fmt::format("{}{}", list.empty() ? "" : ", ", l.label);
  }
  std::string words = fmt::format("{} of {} labels are no segments:", left_out.size(), labels);
  const char* before = " ";
  for (const auto& [reason, list] : of_reason) {
    words += fmt::format("{}{} ({})", before, list, reason);
    before = "; ";
  }
  return words;
}

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
