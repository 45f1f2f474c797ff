// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/region_frame.h>

#include <cstddef>

namespace facetloc {

template <typename PointT>
std::optional<SegmentFrame> regionFrame(const pcl::PointCloud<PointT>& cloud, const pcl::Indices& inliers,
                                        const Eigen::Vector3f& viewpoint, const SensorNoise& noise,
                                        const SegmentEstimationParams& params) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(inliers.size());
  for (const auto i : inliers)
    if (0 <= i && static_cast<std::size_t>(i) < cloud.size())
      points.push_back(cloud[static_cast<std::size_t>(i)].getVector3fMap().template cast<double>());
  const std::optional<Segment> segment =
      regionSegment(points, viewpoint.template cast<double>(), noise, params);
  return segment ? std::optional(toSegmentFrame(*segment)) : std::nullopt;
}

template <typename PointT>
std::optional<SegmentFrame> regionFrame(const pcl::ModelCoefficients& plane,
                                        const pcl::PointCloud<PointT>& hull, const Eigen::Vector3f& viewpoint,
                                        const SensorNoise& noise, const SegmentEstimationParams& params) {
  if (plane.values.size() != 4) return std::nullopt;
  std::vector<Eigen::Vector3d> outline;
  for (const PointT& p : hull) outline.push_back(p.getVector3fMap().template cast<double>());
  const Eigen::Vector4d coefficients = Eigen::Vector4f(plane.values.data()).template cast<double>();
  const std::optional<Segment> segment =
      regionSegment(coefficients, outline, viewpoint.template cast<double>(), noise, params);
  return segment ? std::optional(toSegmentFrame(*segment)) : std::nullopt;
}

}  // namespace facetloc
