// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/depth_image.h>
#include <facetloc/features/params.h>

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

/** \brief Settings of PCL's ways, in the proportions of PCL's tutorials to the edge of the voxels. */
struct PeerParams {
  static constexpr const char* kTitle = "PCL's own registrations, as a yardstick";
  double voxel = 0.05, max_depth = 5, gicp_distance = 0.5, ndt_resolution = 1, ndt_voxel = 0.2;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("voxel", p.voxel, 0.001, 1.0, "Edge of the voxels whose points become one [m].");
    visit("max_depth", p.max_depth, 0.1, 100.0, "Farthest depth that is used [m].");
    visit("gicp_distance", p.gicp_distance, 0.001, 10.0,
          "Largest distance of corresponding points of GICP [m].");
    visit("ndt_resolution", p.ndt_resolution, 0.01, 10.0, "Edge of the cells of NDT [m].");
    visit("ndt_voxel", p.ndt_voxel, 0.001, 1.0, "Edge of the voxels of the source of NDT [m].");
  }
};

/** \brief PlanarRegistration, and PlanarSegmentation, SegmentFrameEstimation and EkfRegistration, with
 * nothing set but the camera. */
std::vector<CloudRegistration> ours(const Camera& camera);
/** \brief FPFH with SampleConsensusPrerejective and with SampleConsensusInitialAlignment, each refined by
 * ICP; GICP and NDT from the identity. */
std::vector<CloudRegistration> peers(const PeerParams& params);

}  // namespace facetloc::benchmarks
