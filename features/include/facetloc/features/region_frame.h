// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment_estimation.h>
#include <facetloc/features/segment_frame.h>

#include <pcl/ModelCoefficients.h>

#include <optional>
#include <vector>

namespace facetloc {

/** \brief The segment of a planar region of any cloud, organized or not, that somebody else has found
 * (METHOD 7.4).
 *
 *     pcl::SACSegmentation<pcl::PointXYZ> segmentation;  // or any other
 *     segmentation.segment(inliers, coefficients);
 *     if (const auto frame = facetloc::regionFrame(cloud, inliers.indices, viewpoint, noise))
 *       frames.push_back(*frame);
 *
 * The plane is fitted by least squares in inverse distance from the viewpoint. Pixels that share their error
 * are counted by the solid angle under which the region is seen, not by points: a cloud that was thinned out
 * has the same covariance. num_points, too, is the area that the region would have in an image of 320x240 px
 * of a Kinect.
 *
 * \param points of the region, in any frame; those that are not finite do not count
 * \param viewpoint where the camera was, in that frame [m]
 * \param noise of the camera that saw them, of which that at the region's distance counts
 * \return the segment in that frame, its normal away from the viewpoint; nothing for points that span no
 * plane, or fail a test of the parameters (METHOD 8) */
std::optional<Segment> regionSegment(const std::vector<Eigen::Vector3d>& points,
                                     const Eigen::Vector3d& viewpoint, const SensorNoise& noise,
                                     const SegmentEstimationParams& params = {});

/** \brief The segment of a region with known plane and outline, as a camera would measure it that
 * sees all of it. \param plane (a, b, c, d) of a x + b y + c z + d = 0, of any length
 * \param outline points on the plane, whose convex hull is the region */
std::optional<Segment> regionSegment(const Eigen::Vector4d& plane,
                                     const std::vector<Eigen::Vector3d>& outline,
                                     const Eigen::Vector3d& viewpoint, const SensorNoise& noise,
                                     const SegmentEstimationParams& params = {});

/** \brief Both in PCL's words: the inliers of a segmenter, which need no coefficients. Indices beyond the
 * cloud do not count. */
template <typename PointT>
std::optional<SegmentFrame> regionFrame(const pcl::PointCloud<PointT>& cloud, const pcl::Indices& inliers,
                                        const Eigen::Vector3f& viewpoint, const SensorNoise& noise,
                                        const SegmentEstimationParams& params = {});
/** \brief The coefficients of a segmenter and the points of its hull. Nothing for other than four
 * coefficients. */
template <typename PointT>
std::optional<SegmentFrame> regionFrame(const pcl::ModelCoefficients& plane,
                                        const pcl::PointCloud<PointT>& hull, const Eigen::Vector3f& viewpoint,
                                        const SensorNoise& noise, const SegmentEstimationParams& params = {});

}  // namespace facetloc

#include <facetloc/features/impl/region_frame.hpp>
