// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

namespace facetloc::benchmarks {

/** \brief The planes of an organized cloud by PCL: integral-image normals and
 * OrganizedMultiPlaneSegmentation, with the settings of its tutorials: normals by covariance, smoothed over
 * 10 px, depth change factor 0.02, 3 deg and 2 cm, with refinement.
 *
 * \param min_inliers smallest plane [points]
 * \return the k-th plane as label k */
LabelImage planesByPcl(const pcl::PointCloud<pcl::PointXYZ>::ConstPtr& cloud, unsigned min_inliers);

}  // namespace facetloc::benchmarks
