// SPDX-License-Identifier: BSD-3-Clause
//
// Where in a map was the camera of a cloud?
//
//   localize_cloud MAP.flmap CLOUD.pcd
#include <facetloc/io/map_database.h>
#include <facetloc/localization/map_localization.h>

#include <pcl/io/pcd_io.h>

#include <iostream>

int main(int argc, char** argv) try {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  if (argc != 3 || pcl::io::loadPCDFile(argv[2], *cloud) < 0) {
    std::cerr << "usage: localize_cloud MAP.flmap CLOUD.pcd\n";
    return 2;
  }
  const auto map = std::make_shared<const facetloc::Map>(facetloc::openMap(argv[1]));
  facetloc::MapLocalization<pcl::PointXYZ> localization;
  localization.setMap(map);
  localization.setCamera(map->camera);  // the cloud is from the camera that has made the map
  localization.setInputCloud(cloud);
  facetloc::PoseWithCovariance pose;
  if (!localization.localize(pose)) {
    std::cout << "not sure: " << localization.getReason() << "\n";
    return 1;
  }
  std::cout << "sure, probability " << localization.getProbability() << " at "
            << pose.T.translation().transpose() << "\n";
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
