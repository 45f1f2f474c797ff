// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_registrations.h"
#include "rigid.h"

#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/ia_ransac.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>
#include <pcl/registration/sample_consensus_prerejective.h>

namespace facetloc::benchmarks {
namespace {

using Features = pcl::PointCloud<pcl::FPFHSignature33>;

constexpr std::size_t kLeastPoints = 100;

// Proportions to the edge of the voxels, of PCL's tutorials "Robust pose estimation of rigid objects" and
// "How to use iterative closest point" (pairwise registration).
constexpr double kNormalRadius = 2, kFeatureRadius = 5, kInlierDistance = 2.5, kIcpDistance = 2;
constexpr double kSampleDistance = 10;  // as in "Aligning object templates to a point cloud"
constexpr int kIcpIterations = 50, kPrerejectiveIterations = 50000, kInitialIterations = 500;

Cloud::Ptr thinned(const Cloud& cloud, double voxel, double max_depth) {
  const auto measured = pcl::make_shared<Cloud>(), thin = pcl::make_shared<Cloud>();
  for (const pcl::PointXYZ& p : cloud)
    if (pcl::isXYZFinite(p) && p.z <= max_depth) measured->push_back(p);
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(measured);
  const auto edge = static_cast<float>(voxel);
  grid.setLeafSize(edge, edge, edge);
  grid.filter(*thin);
  return thin;
}

struct Described {
  Cloud::Ptr cloud;
  Features::Ptr features;
};

Described describe(const Cloud& cloud, const PeerParams& params) {
  Described out{thinned(cloud, params.voxel, params.max_depth), pcl::make_shared<Features>()};
  const auto normals = pcl::make_shared<pcl::PointCloud<pcl::Normal>>();
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(out.cloud);
  estimation.setRadiusSearch(kNormalRadius * params.voxel);
  estimation.compute(*normals);
  // FPFH refuses points without a normal.
  const auto kept = pcl::make_shared<Cloud>();
  const auto kept_normals = pcl::make_shared<pcl::PointCloud<pcl::Normal>>();
  for (std::size_t i = 0; i < normals->size(); ++i)
    if (pcl::isNormalFinite((*normals)[i])) {
      kept->push_back((*out.cloud)[i]);
      kept_normals->push_back((*normals)[i]);
    }
  out.cloud = kept;
  if (kept->size() < kLeastPoints) return out;
  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> fpfh;
  fpfh.setInputCloud(out.cloud);
  fpfh.setInputNormals(kept_normals);
  fpfh.setRadiusSearch(kFeatureRadius * params.voxel);
  fpfh.compute(*out.features);
  return out;
}

template <class Registration>
CloudAnswer answerOf(Registration& registration, double range) {
  CloudAnswer answer;
  answer.has_pose = registration.getFinalTransformation().allFinite();
  answer.converged = answer.has_pose && registration.hasConverged();
  if (answer.has_pose) answer.T = rigid(registration.getFinalTransformation());
  answer.merit = -registration.getFitnessScore(range * range);
  return answer;
}

template <class Registration>
CloudAnswer run(Registration& registration, const Cloud::ConstPtr& source, const Cloud::ConstPtr& target,
                const Eigen::Matrix4f& guess, double range) {
  registration.setInputSource(source);
  registration.setInputTarget(target);
  Cloud aligned;
  registration.align(aligned, guess);
  return answerOf(registration, range);
}

CloudAnswer refined(const CloudAnswer& coarse, const Described& source, const Described& target,
                    const PeerParams& params) {
  if (!coarse.converged) return coarse;
  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  icp.setMaxCorrespondenceDistance(kIcpDistance * params.voxel);
  icp.setMaximumIterations(kIcpIterations);
  return run(icp, source.cloud, target.cloud, coarse.T.matrix().cast<float>(),
             kInlierDistance * params.voxel);
}

template <class Registration>
CloudAnswer alignFeatures(Registration& registration, const Described& source, const Described& target,
                          const PeerParams& params) {
  if (source.features->empty() || target.features->empty()) return {};
  std::srand(1);  // which both draw from
  registration.setSourceFeatures(source.features);
  registration.setTargetFeatures(target.features);
  const double range = kInlierDistance * params.voxel;
  return refined(run(registration, source.cloud, target.cloud, Eigen::Matrix4f::Identity(), range), source,
                 target, params);
}

CloudAnswer byPrerejection(const Described& source, const Described& target, const PeerParams& params) {
  pcl::SampleConsensusPrerejective<pcl::PointXYZ, pcl::PointXYZ, pcl::FPFHSignature33> registration;
  registration.setMaximumIterations(kPrerejectiveIterations);
  registration.setNumberOfSamples(3);
  registration.setCorrespondenceRandomness(5);
  registration.setSimilarityThreshold(0.9f);
  registration.setMaxCorrespondenceDistance(kInlierDistance * params.voxel);
  registration.setInlierFraction(0.25f);
  return alignFeatures(registration, source, target, params);
}

CloudAnswer byInitialAlignment(const Described& source, const Described& target, const PeerParams& params) {
  pcl::SampleConsensusInitialAlignment<pcl::PointXYZ, pcl::PointXYZ, pcl::FPFHSignature33> registration;
  registration.setMinSampleDistance(static_cast<float>(kSampleDistance * params.voxel));
  registration.setMaxCorrespondenceDistance(kInlierDistance * params.voxel);
  registration.setMaximumIterations(kInitialIterations);
  return alignFeatures(registration, source, target, params);
}

CloudAnswer byGicp(const Cloud::ConstPtr& source, const Cloud::ConstPtr& target, const PeerParams& params) {
  const Cloud::Ptr a = thinned(*source, params.voxel, params.max_depth),
                   b = thinned(*target, params.voxel, params.max_depth);
  if (a->size() < kLeastPoints || b->size() < kLeastPoints) return {};
  pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
  gicp.setMaxCorrespondenceDistance(params.gicp_distance);
  gicp.setMaximumIterations(kIcpIterations);
  return run(gicp, a, b, Eigen::Matrix4f::Identity(), kInlierDistance * params.voxel);
}

// Follows the tutorial "How to use Normal Distributions Transform".
CloudAnswer byNdt(const Cloud::ConstPtr& source, const Cloud::ConstPtr& target, const PeerParams& params) {
  const Cloud::Ptr a = thinned(*source, params.ndt_voxel, params.max_depth),
                   b = thinned(*target, params.voxel / 2, params.max_depth);
  if (a->size() < kLeastPoints || b->size() < kLeastPoints) return {};
  pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> ndt;
  ndt.setTransformationEpsilon(0.01);
  ndt.setStepSize(0.1);
  ndt.setResolution(static_cast<float>(params.ndt_resolution));
  ndt.setMaximumIterations(35);
  return run(ndt, a, b, Eigen::Matrix4f::Identity(), kInlierDistance * params.voxel);
}

}  // namespace

std::vector<CloudRegistration> peers(const PeerParams& params) {
  const auto by_features = [params](auto* align) {
    return [params, align](const Cloud::ConstPtr& source, const Cloud::ConstPtr& target) {
      return align(describe(*source, params), describe(*target, params), params);
    };
  };
  const auto by_points = [params](auto* align) {
    return [params, align](const Cloud::ConstPtr& source, const Cloud::ConstPtr& target) {
      return align(source, target, params);
    };
  };
  return {{"FPFH, SampleConsensusPrerejective, ICP", by_features(byPrerejection)},
          {"FPFH, SampleConsensusInitialAlignment, ICP", by_features(byInitialAlignment)},
          {"GICP", by_points(byGicp)},
          {"NDT", by_points(byNdt)}};
}

}  // namespace facetloc::benchmarks
