// SPDX-License-Identifier: BSD-3-Clause
//
// A depth camera, live: the planes that it sees, and a picture of the last image.
//
//   watch_camera DEVICE N PICTURE.png
//
// DEVICE is "" (the first camera), an .oni recording, a folder of depth images or a .scene file; N images are
// watched.
#include <facetloc/io/png.h>
#include <facetloc/openni/openni_grabber.h>
#include <facetloc/segmentation/planar_segmentation.h>

#include <chrono>
#include <iostream>
#include <mutex>
#include <thread>

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/** A colour for each plane. */
facetloc::Raster<std::uint8_t> pictureOf(const facetloc::LabelImage& labels) {
  facetloc::Raster<std::uint8_t> picture{labels.width, labels.height, 3, {}};
  for (const std::uint16_t label : labels.label)
    for (const int channel : {47, 101, 173})
      picture.data.push_back(static_cast<std::uint8_t>(label == 0 ? 40 : 80 + label * channel % 176));
  return picture;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::cerr << "usage: watch_camera DEVICE N PICTURE.png\n";
    return 2;
  }
  facetloc::OpenNIGrabber grabber(argv[1]);
  std::mutex mutex;
  Cloud::ConstPtr newest;
  grabber.registerCallback<void(const Cloud::ConstPtr&)>([&](const Cloud::ConstPtr& cloud) {
    const std::lock_guard lock(mutex);
    newest = cloud;  // take it and return: the next image waits
  });
  grabber.start();
  facetloc::PlanarSegmentation<pcl::PointXYZ> segmentation;
  for (int i = 0; i < std::stoi(argv[2]) && !grabber.isEndOfFile() && grabber.isConnected();) {
    Cloud::ConstPtr cloud;
    {
      const std::lock_guard lock(mutex);
      cloud.swap(newest);
    }
    if (!cloud) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      continue;
    }
    segmentation.setInputCloud(cloud);
    std::vector<pcl::PointIndices> segments;
    segmentation.segment(segments);
    std::cout << "image " << ++i << ": " << segments.size() << " planes\n";
  }
  grabber.stop();
  const facetloc::LabelImage& labels = segmentation.getSegmentation().labels;
  if (labels.width == 0) {
    std::cerr << "no image came" << grabber.lastError() << "\n";
    return 1;
  }
  writePng(argv[3], pictureOf(labels));
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
