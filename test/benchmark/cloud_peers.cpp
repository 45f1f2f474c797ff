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
constexpr double kVoxel = 0.05;        // edge of the voxels whose points become one [m]
constexpr double kMaxDepth = 5;        // farthest depth that is used [m]
constexpr double kNdtVoxel = 0.2;      // edge of the voxels of the source of NDT [m]
constexpr float kNdtResolution = 1;    // edge of the cells of NDT [m]
constexpr double kGicpDistance = 0.5;  // largest distance of corresponding points of GICP [m]

// Proportions to the edge of the voxels, of PCL's tutorials "Robust pose estimation of rigid objects" and
// "How to use iterative closest point" (pairwise registration).
constexpr double kNormalRadius = 2, kFeatureRadius = 5, kInlierDistance = 2.5, kIcpDistance = 2;
constexpr double kSampleDistance = 10;  // as in "Aligning object templates to a point cloud"
constexpr int kIcpIterations = 50, kPrerejectiveIterations = 50000, kInitialIterations = 500;

Cloud::Ptr thinned(const Cloud& cloud, double voxel) {
  const auto measured = pcl::make_shared<Cloud>(), thin = pcl::make_shared<Cloud>();
  for (const pcl::PointXYZ& p : cloud)
    if (pcl::isXYZFinite(p) && p.z <= kMaxDepth) measured->push_back(p);
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

Described describe(const Cloud& cloud) {
  Described out{thinned(cloud, kVoxel), pcl::make_shared<Features>()};
  const auto normals = pcl::make_shared<pcl::PointCloud<pcl::Normal>>();
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(out.cloud);
  estimation.setRadiusSearch(kNormalRadius * kVoxel);
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
  fpfh.setRadiusSearch(kFeatureRadius * kVoxel);
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

CloudAnswer refined(const CloudAnswer& coarse, const Described& source, const Described& target) {
  if (!coarse.converged) return coarse;
  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  icp.setMaxCorrespondenceDistance(kIcpDistance * kVoxel);
  icp.setMaximumIterations(kIcpIterations);
  return run(icp, source.cloud, target.cloud, coarse.T.matrix().cast<float>(), kInlierDistance * kVoxel);
}

template <class Registration>
CloudAnswer alignFeatures(Registration& registration, const Described& source, const Described& target) {
  if (source.features->empty() || target.features->empty()) return {};
  std::srand(1);  // which both draw from
  registration.setSourceFeatures(source.features);
  registration.setTargetFeatures(target.features);
  const double range = kInlierDistance * kVoxel;
  return refined(run(registration, source.cloud, target.cloud, Eigen::Matrix4f::Identity(), range), source,
                 target);
}

CloudAnswer byPrerejection(const Described& source, const Described& target) {
  pcl::SampleConsensusPrerejective<pcl::PointXYZ, pcl::PointXYZ, pcl::FPFHSignature33> registration;
  registration.setMaximumIterations(kPrerejectiveIterations);
  registration.setNumberOfSamples(3);
  registration.setCorrespondenceRandomness(5);
  registration.setSimilarityThreshold(0.9f);
  registration.setMaxCorrespondenceDistance(kInlierDistance * kVoxel);
  registration.setInlierFraction(0.25f);
  return alignFeatures(registration, source, target);
}

CloudAnswer byInitialAlignment(const Described& source, const Described& target) {
  pcl::SampleConsensusInitialAlignment<pcl::PointXYZ, pcl::PointXYZ, pcl::FPFHSignature33> registration;
  registration.setMinSampleDistance(static_cast<float>(kSampleDistance * kVoxel));
  registration.setMaxCorrespondenceDistance(kInlierDistance * kVoxel);
  registration.setMaximumIterations(kInitialIterations);
  return alignFeatures(registration, source, target);
}

CloudAnswer byGicp(const Cloud::ConstPtr& source, const Cloud::ConstPtr& target) {
  const Cloud::Ptr a = thinned(*source, kVoxel), b = thinned(*target, kVoxel);
  if (a->size() < kLeastPoints || b->size() < kLeastPoints) return {};
  pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
  gicp.setMaxCorrespondenceDistance(kGicpDistance);
  gicp.setMaximumIterations(kIcpIterations);
  return run(gicp, a, b, Eigen::Matrix4f::Identity(), kInlierDistance * kVoxel);
}

// Follows the tutorial "How to use Normal Distributions Transform".
CloudAnswer byNdt(const Cloud::ConstPtr& source, const Cloud::ConstPtr& target) {
  const Cloud::Ptr a = thinned(*source, kNdtVoxel), b = thinned(*target, kVoxel / 2);
  if (a->size() < kLeastPoints || b->size() < kLeastPoints) return {};
  pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> ndt;
  ndt.setTransformationEpsilon(0.01);
  ndt.setStepSize(0.1);
  ndt.setResolution(kNdtResolution);
  ndt.setMaximumIterations(35);
  return run(ndt, a, b, Eigen::Matrix4f::Identity(), kInlierDistance * kVoxel);
}

}  // namespace

std::vector<CloudRegistration> peers() {
  const auto by_features = [](auto* align) {
    return [align](const Cloud::ConstPtr& source, const Cloud::ConstPtr& target) {
      return align(describe(*source), describe(*target));
    };
  };
  return {{"FPFH, SampleConsensusPrerejective, ICP", by_features(byPrerejection)},
          {"FPFH, SampleConsensusInitialAlignment, ICP", by_features(byInitialAlignment)},
          {"GICP", byGicp},
          {"NDT", byNdt}};
}

}  // namespace facetloc::benchmarks
