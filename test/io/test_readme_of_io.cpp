// SPDX-License-Identifier: BSD-3-Clause
//
// The grabber of io/README.md, as it stands there but for a sequence in the place of the first camera.
#include "temporary_folder.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/openni/openni_grabber.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <utility>

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;
using CloudPtr = pcl::PointCloud<pcl::PointXYZ>::ConstPtr;

class Mailbox {
public:
  void put(CloudPtr cloud) {
    const std::lock_guard lock(mutex_);
    cloud_ = std::move(cloud);
    filled_.notify_all();
  }
  CloudPtr take(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    filled_.wait_for(lock, patience, [this] { return cloud_ != nullptr; });
    return std::exchange(cloud_, nullptr);
  }

private:
  std::mutex mutex_;
  std::condition_variable filled_;
  CloudPtr cloud_;
};

void watchCamera(Mailbox& newest, const std::function<void(const CloudPtr&)>& work){
#include "example_watch_camera.inc"
}

TEST(ReadmeOfIo, TheGrabberDeliversClouds) {
  const TemporaryFolder folder;
  const Intrinsics camera{64, 48, 58, 58, 31.5, 23.5};
  std::filesystem::create_directories(folder / "walk/depth");
  CameraFile file;
  file.camera.intrinsics = camera;
  writeCameraFile(folder / "walk/camera.ini", file);
  for (const char* stamp : {"0.1", "0.2", "0.3", "0.4", "0.5"})
    writeDepthPng(folder / (std::string("walk/depth/") + stamp + ".png"),
                  {camera, std::vector<float>(64 * 48, 2.f)}, file.depth_scale);
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  Mailbox newest;
  int clouds = 0;
  watchCamera(newest, [&](const CloudPtr& cloud) {
    ++clouds;
    EXPECT_EQ(cloud->width, 64u);
  });
  std::filesystem::current_path(before);
  EXPECT_GE(clouds, 1);
}

}  // namespace
}  // namespace facetloc::test
