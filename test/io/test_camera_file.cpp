// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/rig_file.h>
#include <facetloc/testing/decimal_comma.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <stdexcept>

namespace facetloc::test {
namespace {

constexpr const char* kMinimal = "width=640 height=480 fx=525 fy=526.5 cx=319.5 cy=239.5 depth_scale=5000\n";

CameraFile read(const std::string& content) {
  const TemporaryFolder folder;
  return readCameraFile(putBytes(folder / "camera.ini", content));
}

std::string errorOf(const std::string& content) {
  return ioErrorOf([&] { read(content); });
}

TEST(CameraFile, ReadsSeveralPairsOnALineAndComments) {
  const CameraFile file = read("# a Kinect\n" + std::string(kMinimal) +
                               "mount_height = 0.98  mount_tilt_deg= 10 # on the robot\r\n\n"
                               "inverse_depth_std =0.00142");
  EXPECT_EQ(file.camera.intrinsics, (Intrinsics{640, 480, 525, 526.5, 319.5, 239.5}));
  EXPECT_EQ(file.depth_scale, 5000);
  ASSERT_TRUE(file.camera.mounting);
  EXPECT_EQ(file.camera.mounting->height, 0.98);
  EXPECT_EQ(file.camera.mounting->tilt_deg, 10);
  EXPECT_EQ(file.camera.noise.inverse_depth_std, 0.00142);
}

TEST(CameraFile, MountingAndNoiseAreOptional) {
  const CameraFile file = read(kMinimal);
  EXPECT_FALSE(file.camera.mounting);
  EXPECT_EQ(file.camera.noise.inverse_depth_std, SensorNoise().inverse_depth_std);
}

TEST(CameraFile, KnowsCamerasByName) {
  const CameraFile lidar = read(std::string(kMinimal) + "camera = phone_lidar");
  EXPECT_EQ(lidar.preset, "phone_lidar");
  EXPECT_EQ(lidar.camera.max_depth, 5);
  EXPECT_EQ(lidar.camera.intrinsics.fx, 525) << "each device has its own";

  const CameraFile nearer = read("max_depth=3 depth_std=0.004 camera=phone_lidar\n" + std::string(kMinimal));
  EXPECT_EQ(nearer.camera.max_depth, 3) << "wherever the name stands";
  EXPECT_EQ(nearer.camera.noise.depth_std, 0.004);
  EXPECT_EQ(nearer.camera.noise.depth_std_slope, SensorNoise().depth_std_slope);

  const CameraFile kinect = read(std::string(kMinimal) + "camera=kinect"), unnamed = read(kMinimal);
  EXPECT_EQ(kinect.camera.noise.inverse_depth_std, unnamed.camera.noise.inverse_depth_std);
  EXPECT_EQ(kinect.camera.max_depth, unnamed.camera.max_depth);
  EXPECT_EQ(unnamed.preset, "");
}

TEST(CameraFile, RoundTripsWithTheNameOfTheCamera) {
  for (const CameraPreset& preset : cameraPresets())
    for (const char* more :
         {"", " max_depth=2.5", " depth_std=0.5 distortion_slope=0", " inverse_depth_std=1e-7"}) {
      const TemporaryFolder folder;
      const CameraFile file = read(std::string(kMinimal) + "camera=" + preset.name + more);
      writeCameraFile(folder / "camera.ini", file);
      const CameraFile again = readCameraFile(folder / "camera.ini");
      EXPECT_EQ(again.preset, file.preset);
      EXPECT_EQ(again.camera.max_depth, file.camera.max_depth);
      EXPECT_EQ(toIni(again.camera.noise), toIni(file.camera.noise));
    }
}

TEST(CameraFile, RefusesUnknownCamerasAndImpossibleNoise) {
  const std::string good = kMinimal;
  EXPECT_THAT(errorOf(good + "camera=nikon"),
              HasAll("line 2", "'nikon'", "azure_kinect", "inverse_depth_std"));
  EXPECT_THAT(errorOf(good + "camera="), HasSubstr("line 2"));
  EXPECT_THAT(errorOf(good + "camera=kinect camera=kinect"), HasSubstr("twice"));
  for (const char* pair :
       {"max_depth=0", "max_depth=-1", "max_depth=nan", "max_depth=inf", "depth_std=-0.001", "depth_std=2",
        "depth_std_slope=0.6", "depth_std_slope=-1", "inverse_depth_std=0", "inverse_depth_std=2",
        "distortion_offset=-1", "distortion_slope=7"}) {
    const std::string key = std::string(pair).substr(0, std::string(pair).find('='));
    EXPECT_THAT(errorOf(good + pair), HasAll("line 2", key, "impossible", "left out"));
  }
}

TEST(CameraFile, RoundTripsExactly) {
  const TemporaryFolder folder;
  CameraFile file;
  Camera& camera = file.camera;
  camera.intrinsics = {320, 240, 262.5 + 1.0 / 3, 1e-3, -17.25, 119.75};
  file.depth_scale = 1000.0 / 7;
  camera.mounting = CameraMounting{1.0 / 3, -12.3456789};
  camera.noise.inverse_depth_std = 0.1 / 3;
  writeCameraFile(folder / "camera.ini", file);
  const CameraFile again = readCameraFile(folder / "camera.ini");
  EXPECT_EQ(again.camera.intrinsics, camera.intrinsics);
  EXPECT_EQ(again.depth_scale, file.depth_scale);
  EXPECT_EQ(again.camera.mounting->height, camera.mounting->height);
  EXPECT_EQ(again.camera.mounting->tilt_deg, camera.mounting->tilt_deg);
  EXPECT_EQ(again.camera.noise.inverse_depth_std, camera.noise.inverse_depth_std);
}

TEST(CameraFile, MayHaveCapitalsAndLinesOfOtherMachines) {
  std::string content = std::string("# B\xC3\xBCro\n") + kMinimal + "Camera = Kinect\n";
  std::replace(content.begin(), content.end(), 'x', 'X');
  std::replace(content.begin(), content.end(), '\n', '\r');
  EXPECT_EQ(read(content).camera.intrinsics.fx, 525);
  EXPECT_EQ(read(content).preset, "kinect");
}

TEST(CameraFile, DoesNotDependOnTheLocale) {
  const DecimalComma comma;
  EXPECT_EQ(read(kMinimal).camera.intrinsics.fy, 526.5);
  if (!comma.isSetInC()) GTEST_SKIP() << "no German locale: numbers of C have not been tested";
}

TEST(CameraFile, NamesTheLineOfAFault) {
  const std::string good = kMinimal;
  EXPECT_THAT(errorOf(good + "fxx=3"), HasAll("camera.ini", "line 2", "'fxx'"));
  EXPECT_THAT(errorOf(good + "\nmount_height=high"), HasAll("line 3", "'high'"));
  EXPECT_THAT(errorOf(good + "mount_height"), HasAll("line 2", "key = value"));
  EXPECT_THAT(errorOf(good + "mount_height="), HasSubstr("line 2"));
  EXPECT_THAT(errorOf(good + "= 3 ="), HasSubstr("line 2"));
  EXPECT_THAT(errorOf(good + "fx=500"), HasSubstr("twice"));
  EXPECT_THAT(errorOf(good + "mount_height=1,5 mount_tilt_deg=0"), HasSubstr("'1,5'"));
}

TEST(CameraFile, AMountingMayBeTurnedAndMoved) {
  const TemporaryFolder folder;
  CameraFile file;
  file.camera.intrinsics = {640, 480, 525, 525, 319.5, 239.5};
  file.camera.mounting = CameraMounting{0.98, 10, -3.5, 90, 0.25, -0.125};
  writeCameraFile(folder / "camera.ini", file);
  const CameraMounting again = *readCameraFile(folder / "camera.ini").camera.mounting;
  EXPECT_EQ(again.T_b_c().matrix(), file.camera.mounting->T_b_c().matrix());
  EXPECT_THAT(errorOf(kMinimal + std::string("mount_pan_deg=90")),
              HasAll("mount_pan_deg", "not mount_height"));
  EXPECT_THAT(errorOf(kMinimal + std::string("mount_roll_deg=200")), HasSubstr("impossible"));
}

TEST(CameraFile, RefusesImpossibleValues) {
  for (const char* pair : {"width=0", "width=-640", "width=640.5", "width=1e9", "fx=0", "fy=-1", "cx=nan",
                           "cy=inf", "depth_scale=0"}) {
    std::string content = kMinimal;
    const std::string key = std::string(pair).substr(0, std::string(pair).find('=') + 1);
    const auto at = content.find(key);
    content.replace(at, content.find_first_of(" \n", at) - at, pair);
    EXPECT_THAT(errorOf(content), HasSubstr("impossible")) << pair;
  }
}

TEST(CameraFile, RefusesIncompleteFiles) {
  EXPECT_THAT(errorOf(""), HasSubstr("has no width"));
  EXPECT_THAT(errorOf("width=640 height=480 fy=525 cx=319.5 cy=239.5 depth_scale=5000"),
              HasSubstr("has no fx"));
  EXPECT_THAT(errorOf(kMinimal + std::string("mount_height=1")), HasSubstr("mount_tilt_deg"));
}

TEST(CameraFile, MissingFileAndFolderAreErrors) {
  const TemporaryFolder folder;
  EXPECT_THAT(ioErrorOf([&] { readCameraFile(folder / "camera.ini"); }), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { readCameraFile(folder.path()); }), HasSubstr("folder"));
  CameraFile camera;
  EXPECT_THROW(writeCameraFile(folder / "camera.ini", camera), std::invalid_argument);
  camera.camera.intrinsics = kinectIntrinsics();
  EXPECT_NE(ioErrorOf([&] { writeCameraFile(folder / "none/camera.ini", camera); }), "");
}

std::string rigErrorOf(const std::string& content) {
  const TemporaryFolder folder;
  putBytes(folder / "rig.ini", content);
  return ioErrorOf([&] { readRigFile(folder / "rig.ini"); });
}

TEST(RigFile, NamesTheFoldersOfCamerasAndTheirErrors) {
  const TemporaryFolder folder;
  putBytes(folder / "rig.ini", "# a robot\ncameras = front  rear # two\ntranslation_std=0.02\n");
  const auto rig = readRigFile(folder.path());
  ASSERT_TRUE(rig);
  ASSERT_EQ(rig->cameras.size(), 2u);
  EXPECT_EQ(rig->cameras[0].filename(), "front");
  EXPECT_EQ(rig->cameras[1].parent_path(), rig->cameras[0].parent_path());
  EXPECT_EQ(rig->translation_std, 0.02);
  EXPECT_EQ(rig->rotation_std, RigFile().rotation_std);
  EXPECT_FALSE(readRigFile(folder / "front"));
}

// A camera 0.3 m behind the first one that looks back: its axis points against the first one's.
TEST(RigFile, PosesFollowFromTheMountings) {
  const CameraMounting front{1, 0, 0, 0, 0.1, 0}, rear{1, 0, 0, 180, -0.2, 0};
  RigFile rig;
  rig.rotation_std = 0.01;
  const PoseWithCovariance T = rig.between(front, rear);
  EXPECT_TRUE((T.T * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(0, 0, -1.3)));
  EXPECT_TRUE((T.T * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(-1, 0, -0.3)));
  EXPECT_NEAR(T.P(0, 0), 1e-4, 1e-12);
  EXPECT_NEAR(T.P(5, 5), rig.translation_std * rig.translation_std, 1e-12);
}

TEST(RigFile, FaultsAreNamedWithTheirLine) {
  EXPECT_THAT(rigErrorOf("cameras = front\n"), HasSubstr("fewer than two cameras"));
  EXPECT_THAT(rigErrorOf("cameras = a a\n"), HasSubstr("line 1: camera a is named twice"));
  EXPECT_THAT(rigErrorOf("\ncameras a b\n"), HasSubstr("line 2: expected key = value"));
  EXPECT_THAT(rigErrorOf("cameras = a b\nrotation_std_deg = -1\n"),
              HasSubstr("line 2: rotation_std_deg = -1"));
  EXPECT_THAT(rigErrorOf("cameras = a b\nangle = 1\n"), HasSubstr("unknown key 'angle'"));
  EXPECT_THAT(rigErrorOf("cameras = a b\ncameras = c d\n"), HasSubstr("cameras is given twice"));
}

}  // namespace
}  // namespace facetloc::test
