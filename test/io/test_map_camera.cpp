// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_camera.h>
#include <facetloc/io/map_database.h>

#include <gmock/gmock.h>

#include <fstream>

namespace facetloc {
namespace {

using test::TemporaryFolder;
using testing::HasSubstr;

Camera mountedCamera() {
  Camera camera;
  camera.intrinsics = {640, 480, 525, 526, 319, 239};
  camera.noise.inverse_depth_std = 0.002;
  camera.mounting = CameraMounting{0.9, 12};
  camera.max_depth = 6;
  return camera;
}

TEST(MapCamera, IsThatOfTheMap) {
  const TemporaryFolder folder;
  MapDatabase::create(folder / "a.flmap").setCamera(mountedCamera());
  EXPECT_TRUE(isMapFile(folder / "a.flmap"));
  CameraFile stored;
  stored.depth_scale = 5000;
  stored.lens.k1 = 0.1;
  stored.camera.intrinsics = {320, 240, 250, 250, 159, 119};
  stored.preset = "kinect";
  const CameraFile file = cameraOfMap(folder / "a.flmap", stored);
  EXPECT_EQ(file.camera.intrinsics, mountedCamera().intrinsics);
  EXPECT_EQ(file.camera.noise.inverse_depth_std, 0.002);
  EXPECT_EQ(file.camera.max_depth, 6);
  ASSERT_TRUE(file.camera.mounting);
  EXPECT_EQ(file.camera.mounting->tilt_deg, 12);
  EXPECT_EQ(file.depth_scale, 5000) << "how images are stored is not of the map";
  EXPECT_EQ(file.lens.k1, 0.1);
}

TEST(MapCamera, NeedsIntrinsicsFromSomewhere) {
  const TemporaryFolder folder;
  Camera camera = mountedCamera();
  camera.intrinsics = {};
  MapDatabase::create(folder / "a.flmap").setCamera(camera);
  CameraFile stored;
  stored.camera.intrinsics = {320, 240, 250, 250, 159, 119};
  EXPECT_EQ(cameraOfMap(folder / "a.flmap", stored).camera.intrinsics, stored.camera.intrinsics);
  try {
    cameraOfMap(folder / "a.flmap");
    ADD_FAILURE() << "no error";
  } catch (const IoError& e) {
    EXPECT_THAT(e.what(), HasSubstr("a.flmap: does not say the intrinsics"));
  }
}

TEST(MapCamera, OfNoMapIsAnError) {
  const TemporaryFolder folder;
  std::ofstream(folder / "short.flmap") << "SQL";
  std::ofstream(folder / "torn.flmap") << "SQLite format 3, and nothing more";
  EXPECT_FALSE(isMapFile(folder / "short.flmap"));
  EXPECT_FALSE(isMapFile(folder / "none.flmap"));
  EXPECT_FALSE(isMapFile(folder / ""));
  EXPECT_TRUE(isMapFile(folder / "torn.flmap"));
  EXPECT_THROW(cameraOfMap(folder / "torn.flmap"), IoError);
}

}  // namespace
}  // namespace facetloc
