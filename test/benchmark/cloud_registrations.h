// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/depth_image.h>

#include <Eigen/Geometry>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <functional>
#include <string>
#include <vector>

namespace facetloc::benchmarks {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/** \brief The answer of a registration of two clouds. */
struct CloudAnswer {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();  ///< T_target_source
  bool has_pose = false, converged = false;
  double merit = 0;  ///< its quality, more is better: the probability, or the negative fitness
};

/** \brief A way to register two organized clouds as a depth camera gives them. */
struct CloudRegistration {
  std::string name;
  std::function<CloudAnswer(const Cloud::ConstPtr& source, const Cloud::ConstPtr& target)> align;
};

/** \brief PlanarRegistration, and PlanarSegmentation, SegmentFrameEstimation and EkfRegistration, with
 * nothing set but the camera. */
std::vector<CloudRegistration> ours(const Camera& camera);
/** \brief FPFH with SampleConsensusPrerejective and with SampleConsensusInitialAlignment, each refined by
 * ICP; GICP and NDT from the identity. */
std::vector<CloudRegistration> peers();

}  // namespace facetloc::benchmarks
