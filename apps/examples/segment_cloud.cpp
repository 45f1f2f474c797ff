// SPDX-License-Identifier: BSD-3-Clause
//
// The planes of an organized cloud, and their frames for pcl_viewer and for registration:
//
//   segment_cloud CLOUD.pcd SEGMENTS.pcd
#include <facetloc/features/segment_frame_estimation.h>
#include <facetloc/segmentation/planar_segmentation.h>

#include <pcl/io/pcd_io.h>

#include <iostream>

int main(int argc, char** argv) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  if (argc != 3 || pcl::io::loadPCDFile(argv[1], *cloud) < 0) {
    std::cerr << "usage: segment_cloud CLOUD.pcd SEGMENTS.pcd\n";
    return 2;
  }
  facetloc::PlanarSegmentation<pcl::PointXYZ> segmentation;
  segmentation.setInputCloud(cloud);
  auto labels = pcl::make_shared<pcl::PointCloud<pcl::Label>>();
  segmentation.segment(*labels);

  facetloc::Camera camera;
  camera.noise.inverse_depth_std =
      segmentation.getSegmentation().noise;  // the noise measured in these points
  facetloc::SegmentFrameEstimation<pcl::PointXYZ> estimation;
  estimation.setInputCloud(cloud);
  estimation.setLabels(labels);
  estimation.setCamera(camera);
  pcl::PointCloud<facetloc::SegmentFrame> frames;
  estimation.compute(frames);
  if (frames.empty()) {
    std::cerr << segmentation.getReason() << estimation.getReason() << "\n";
    return 1;
  }
  for (const facetloc::SegmentFrame& frame : frames)
    std::cout << frame.num_points << " points about " << frame.getVector3fMap().transpose() << ", normal "
              << frame.normal().transpose() << "\n";
  return pcl::io::savePCDFileBinary(argv[2], frames) < 0 ? 1 : 0;
}
