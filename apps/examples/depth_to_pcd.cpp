// SPDX-License-Identifier: BSD-3-Clause
//
// The depth images of a recording as organized PCD files, as PCL's programs read them:
//
//   depth_to_pcd RECORDING DIR
#include <facetloc/io/depth_sequence.h>

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <exception>
#include <filesystem>
#include <iostream>
#include <limits>

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: depth_to_pcd RECORDING DIR\n";
    return 2;
  }
  const std::filesystem::path folder = argv[2];
  std::filesystem::create_directories(folder);
  const auto sequence = facetloc::DepthSequence::open(argv[1]);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
    const facetloc::DepthImage image = sequence.load(i);
    pcl::PointCloud<pcl::PointXYZ> cloud(image.camera.width, image.camera.height, {nan, nan, nan});
    for (int v = 0; v < image.camera.height; ++v)
      for (int u = 0; u < image.camera.width; ++u)
        if (const float z = image.at(u, v); z > 0)  // 0 = not measured
          cloud(u, v).getVector3fMap() = z * image.camera.ray(u, v).cast<float>();
    cloud.is_dense = false;
    pcl::io::savePCDFileBinary((folder / (sequence.frames()[i].name + ".pcd")).string(), cloud);
  }
  std::cout << sequence.frames().size() << " clouds in " << folder.string() << "\n";
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
