// SPDX-License-Identifier: BSD-3-Clause
//
// Where was the camera of one cloud, seen from the camera of another one? And the first cloud over there:
//
//   register_clouds SOURCE.pcd TARGET.pcd ALIGNED.pcd
#include <facetloc/registration/planar_registration.h>

#include <pcl/io/pcd_io.h>

#include <iostream>

int main(int argc, char** argv) {
  using Cloud = pcl::PointCloud<pcl::PointXYZ>;
  auto source = pcl::make_shared<Cloud>(), target = pcl::make_shared<Cloud>();
  if (argc != 4 || pcl::io::loadPCDFile(argv[1], *source) < 0 || pcl::io::loadPCDFile(argv[2], *target) < 0) {
    std::cerr << "usage: register_clouds SOURCE.pcd TARGET.pcd ALIGNED.pcd\n";
    return 2;
  }
  facetloc::PlanarRegistration<pcl::PointXYZ> registration;  // a pcl::Registration<PointXYZ, PointXYZ>
  registration.setInputSource(source);
  registration.setInputTarget(target);
  Cloud aligned;
  registration.align(aligned);
  if (!registration.hasConverged()) {  // not sure: a guess, or nothing
    std::cerr << registration.getReason() << "\n";
    return 1;
  }
  std::cout << "probability " << registration.getProbability() << ", one of "
            << registration.getHypotheses().size() << " poses\n"
            << registration.getFinalPose().matrix() << "\n";
  return pcl::io::savePCDFileBinary(argv[3], aligned) < 0 ? 1 : 0;
}
