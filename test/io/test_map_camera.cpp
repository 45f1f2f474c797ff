// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/camera_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>

namespace facetloc::test {
namespace {

Camera mountedCamera() {
  Camera camera;
  camera.intrinsics = {640, 480, 525, 526, 319, 239};
  camera.noise.inverse_depth_std = 0.002;
  camera.mounting = CameraMounting{0.9, 12};
  camera.max_depth = 6;
  return camera;
}

using MapCamera = InAFolder;

TEST_F(MapCamera, IsThatOfTheMap) {
  MapDatabase::create(folder_ / "a.flmap").setCamera(mountedCamera());
  EXPECT_TRUE(isMapFile(folder_ / "a.flmap"));
  CameraFile stored;
  stored.depth_scale = 5000;
  stored.lens.k1 = 0.1;
  stored.camera.intrinsics = {320, 240, 250, 250, 159, 119};
  stored.preset = "kinect";
  const CameraFile file = cameraOfMap(folder_ / "a.flmap", stored);
  EXPECT_EQ(file.camera.intrinsics, mountedCamera().intrinsics);
  EXPECT_EQ(file.camera.noise.inverse_depth_std, 0.002);
  EXPECT_EQ(file.camera.max_depth, 6);
  ASSERT_TRUE(file.camera.mounting);
  EXPECT_EQ(file.camera.mounting->tilt_deg, 12);
  EXPECT_EQ(file.depth_scale, 5000) << "how images are stored is not of the map";
  EXPECT_EQ(file.lens.k1, 0.1);
}

TEST_F(MapCamera, NeedsIntrinsicsFromSomewhere) {
  Camera camera = mountedCamera();
  camera.intrinsics = {};
  MapDatabase::create(folder_ / "a.flmap").setCamera(camera);
  CameraFile stored;
  stored.camera.intrinsics = {320, 240, 250, 250, 159, 119};
  EXPECT_EQ(cameraOfMap(folder_ / "a.flmap", stored).camera.intrinsics, stored.camera.intrinsics);
  EXPECT_THAT(ioErrorOf([&] { cameraOfMap(folder_ / "a.flmap"); }),
              HasSubstr("a.flmap: does not say the intrinsics"));
}

TEST_F(MapCamera, OfNoMapIsAnError) {
  std::ofstream(folder_ / "short.flmap") << "SQL";
  std::ofstream(folder_ / "torn.flmap") << "SQLite format 3, and nothing more";
  EXPECT_FALSE(isMapFile(folder_ / "short.flmap"));
  EXPECT_FALSE(isMapFile(folder_ / "none.flmap"));
  EXPECT_FALSE(isMapFile(folder_ / ""));
  EXPECT_TRUE(isMapFile(folder_ / "torn.flmap"));
  EXPECT_THROW(cameraOfMap(folder_ / "torn.flmap"), IoError);
}

}  // namespace
}  // namespace facetloc::test
