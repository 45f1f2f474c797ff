// SPDX-License-Identifier: BSD-3-Clause
//
// Segment frames of the planes that PCL's own RANSAC finds in a cloud without order, and where one cloud was
// seen from, relative to the other, by these frames alone:
//
//   any_segmenter SOURCE.pcd TARGET.pcd
#include <facetloc/features/region_frame.h>
#include <facetloc/registration/ekf_registration.h>

#include <pcl/io/pcd_io.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <iostream>
#include <iterator>

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

pcl::PointCloud<facetloc::SegmentFrame>::Ptr framesOf(const Cloud::ConstPtr& cloud) {
  pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  segmentation.setModelType(pcl::SACMODEL_PLANE);
  segmentation.setMethodType(pcl::SAC_RANSAC);
  segmentation.setDistanceThreshold(0.02);
  segmentation.setOptimizeCoefficients(false);  // regionFrame() fits the plane itself
  segmentation.setInputCloud(cloud);
  auto left = pcl::make_shared<pcl::Indices>();
  for (std::size_t i = 0; i < cloud->size(); ++i)
    if (pcl::isXYZFinite((*cloud)[i])) left->push_back(static_cast<int>(i));

  auto frames = pcl::make_shared<pcl::PointCloud<facetloc::SegmentFrame>>();
  const facetloc::SensorNoise kinect;
  const std::size_t enough = left->size() / 50;
  for (int plane = 0; plane < 10 && left->size() > enough; ++plane) {
    segmentation.setIndices(left);
    pcl::PointIndices inliers;
    pcl::ModelCoefficients coefficients;
    segmentation.segment(inliers, coefficients);
    if (inliers.indices.size() <= enough) break;
    if (const auto frame =
            facetloc::regionFrame(*cloud, inliers.indices, cloud->sensor_origin_.head<3>(), kinect))
      frames->push_back(*frame);
    auto rest = pcl::make_shared<pcl::Indices>();
    std::set_difference(left->begin(), left->end(), inliers.indices.begin(), inliers.indices.end(),
                        std::back_inserter(*rest));
    left = rest;
  }
  return frames;
}

}  // namespace

int main(int argc, char** argv) {
  auto source = pcl::make_shared<Cloud>(), target = pcl::make_shared<Cloud>();
  if (argc != 3 || pcl::io::loadPCDFile(argv[1], *source) < 0 || pcl::io::loadPCDFile(argv[2], *target) < 0) {
    std::cerr << "usage: any_segmenter SOURCE.pcd TARGET.pcd\n";
    return 2;
  }
  facetloc::EkfRegistration registration;
  registration.setInputSource(framesOf(source));
  registration.setInputTarget(framesOf(target));
  pcl::PointCloud<facetloc::SegmentFrame> aligned;
  registration.align(aligned);
  if (registration.getHypotheses().empty()) {
    std::cerr << registration.getReason() << "\n";
    return 1;
  }
  for (const facetloc::SegmentFrame& frame : aligned) std::cout << frame << "\n";
  std::cout << facetloc::toString(registration.getState()) << ", probability "
            << registration.getProbability() << "\n"
            << registration.getFinalPose().matrix() << "\n";
}
