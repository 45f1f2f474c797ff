// SPDX-License-Identifier: BSD-3-Clause
//
// The templates with a point type of one's own: their bodies are in the headers.
//
//   own_point_type MAP.flmap CLOUD.pcd
//
// PlanarRegistration of an own type needs, as PCL's registrations do, PCL_NO_PRECOMPILE before PCL's headers.
#include <facetloc/io/map_database.h>
#include <facetloc/localization/map_localization.h>
#include <facetloc/segmentation/planar_segmentation.h>

#include <pcl/io/pcd_io.h>

#include <iostream>

struct EIGEN_ALIGN16 RadarPoint {
  PCL_ADD_POINT4D;
  float strength = 0;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};
POINT_CLOUD_REGISTER_POINT_STRUCT(RadarPoint,
                                  (float, x, x)(float, y, y)(float, z, z)(float, strength, strength))

int main(int argc, char** argv) try {
  auto cloud = pcl::make_shared<pcl::PointCloud<RadarPoint>>();
  if (argc != 3 || pcl::io::loadPCDFile(argv[2], *cloud) < 0) {
    std::cerr << "usage: own_point_type MAP.flmap CLOUD.pcd\n";
    return 2;
  }
  facetloc::PlanarSegmentation<RadarPoint> segmentation;
  segmentation.setInputCloud(cloud);
  std::vector<pcl::PointIndices> segments;
  segmentation.segment(segments);

  facetloc::MapLocalization<RadarPoint> localization;
  localization.setMap(std::make_shared<const facetloc::Map>(facetloc::openMap(argv[1])));
  localization.setInputCloud(cloud);
  Eigen::Isometry3d T_w_c;
  const bool is_sure = localization.localize(T_w_c);
  std::cout << segments.size() << " segments; " << toString(localization.getState()) << " at "
            << T_w_c.translation().transpose() << "\n";
  return is_sure ? 0 : 1;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
