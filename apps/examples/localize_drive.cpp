// SPDX-License-Identifier: BSD-3-Clause
//
// Where is a moving camera? By all clouds so far:
//
//   localize_drive MAP.flmap CLOUD_1.pcd CLOUD_2.pcd ...
//
// The clouds are organized, in the order in which they were taken, here at 10 Hz.
#include <facetloc/io/map_database.h>
#include <facetloc/localization/map_localization.h>

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <exception>
#include <iostream>
#include <memory>

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::cerr << "usage: localize_drive MAP.flmap CLOUD.pcd...\n";
    return 2;
  }
  const auto map = std::make_shared<const facetloc::Map>(facetloc::openMap(argv[1]));
  facetloc::MapLocalization<pcl::PointXYZ> drive;
  drive.setMap(map);
  drive.setCamera(map->camera);  // the clouds are from the camera that has made the map
  drive.setSequenceMode(true);
  for (int i = 2; i < argc; ++i) {
    const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
    if (pcl::io::loadPCDFile(argv[i], *cloud) < 0) return 1;
    cloud->header.stamp = 100000u * static_cast<unsigned>(i);  // microseconds
    drive.setInputCloud(cloud);
    facetloc::PoseWithCovariance pose;
    drive.localize(pose);
    const facetloc::Localization& answer = drive.getAnswer();
    std::cout << argv[i] << ": " << toString(answer.state);
    if (answer.hypotheses.empty())
      std::cout << ", " << answer.reason << "\n";
    else
      std::cout << ", " << answer.hypotheses.size() << " places, the first with probability "
                << answer.hypotheses[0].probability << " at "
                << answer.hypotheses[0].T_w_c->translation().transpose() << "\n";
  }
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
