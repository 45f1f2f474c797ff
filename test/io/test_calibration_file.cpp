// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/recording_layout.h"
#include "temporary_folder.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace facetloc::internal {
namespace {

using test::ioErrorOf;
using test::putBytes;
using test::TemporaryFolder;
using testing::HasSubstr;

void expectCamera(const std::string& text, const Intrinsics& expected) {
  const auto found = parseCalibration(text, "c.yaml");
  ASSERT_TRUE(found) << text;
  EXPECT_EQ(found->intrinsics, expected) << text;
}

TEST(CalibrationFile, OfRos) {
  const std::string text =
      "image_width: 640\nimage_height: 480\ncamera_name: depth\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: [500.5, 0, 320, 0, 501, 240, 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n"
      "  rows: 1\n  cols: 5\n  data: [0.1, -0.2, 0.001, 0.002, 0.05]\nrectification_matrix:\n  rows: 3\n"
      "  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
  expectCamera(text, {640, 480, 500.5, 501, 320, 240});
  const LensDistortion lens = parseCalibration(text, "c")->lens;
  EXPECT_EQ(lens.k1, 0.1);
  EXPECT_EQ(lens.k2, -0.2);
  EXPECT_EQ(lens.p1, 0.001);
  EXPECT_EQ(lens.p2, 0.002);
  EXPECT_EQ(lens.k3, 0.05);
}

TEST(CalibrationFile, OfOpenCvAndRtabMap) {
  expectCamera(
      "%YAML:1.0\n---\ncamera_name: \"1.5\"\nimage_width: 640\nimage_height: 480\ncamera_matrix: "
      "!!opencv-matrix\n"
      "   rows: 3\n   cols: 3\n   dt: d\n   data: [ 5.0e+02, 0., 320., 0., 501., 240., 0., 0., 1. ]\n"
      "local_transform:\n   rows: 3\n   cols: 4\n   data: [ 0., 0., 1., 0., -1., 0., 0., 0., 0., -1., 0., 1. "
      "]\n",
      {640, 480, 500, 501, 320, 240});
}

TEST(CalibrationFile, OfKalibr) {
  const std::string text =
      "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0.1, 0.02, 0.003, 0.004]\n  distortion_model: "
      "radtan\n"
      "  intrinsics: [500, 501, 320, 240]\n  resolution: [640, 480]\n  rostopic: /depth/image_raw\n";
  expectCamera(text, {640, 480, 500, 501, 320, 240});
  EXPECT_EQ(parseCalibration(text, "c")->lens.p2, 0.004);
  std::string fisheye = text;
  fisheye.replace(fisheye.find("radtan"), 6, "equidistant");
  EXPECT_THAT(ioErrorOf([&] { parseCalibration(fisheye, "c.yaml"); }), HasSubstr("equidistant"));
}

TEST(CalibrationFile, OfOrbSlamOpen3dAndOthers) {
  const std::string orb =
      "%YAML:1.0\nCamera.fx: 517.3\nCamera.fy: 516.5\nCamera.cx: 318.6\nCamera.cy: 255.3\nCamera.k1: 0.26\n"
      "Camera.k2: -0.95\nCamera.p1: -0.005\nCamera.p2: 0.0026\nCamera.k3: 1.16\nCamera.width: 640\n"
      "Camera.height: 480\nDepthMapFactor: 5000.0 # 1.0 for ROS\n";
  expectCamera(orb, {640, 480, 517.3, 516.5, 318.6, 255.3});
  EXPECT_EQ(parseCalibration(orb, "c")->depth_scale, 5000);
  EXPECT_EQ(parseCalibration(orb, "c")->lens.k3, 1.16);
  expectCamera("{\"width\": 640, \"height\": 480, \"intrinsic_matrix\": [500, 0, 0, 0, 501, 0, 320, 240, 1]}",
               {640, 480, 500, 501, 320, 240});
  expectCamera("{\"width\":640,\"height\":480,\"fx\":500,\"fy\":501,\"ppx\":320,\"ppy\":240}",
               {640, 480, 500, 501, 320, 240});
}

TEST(CalibrationFile, OtherTextsAreNoCalibration) {
  EXPECT_FALSE(parseCalibration("", "c"));
  EXPECT_FALSE(parseCalibration("a: 1\nb: [1, 2, 3]\n", "c"));
  EXPECT_FALSE(parseCalibration("fx: 0\nfy: 1\ncx: 1\ncy: 1\n", "c"));
  EXPECT_FALSE(parseCalibration("{\"fx\": 500", "c"));
  EXPECT_FALSE(parseCalibration("camera_matrix:\n  data: [1, 2, 3]\n", "c"));
}

TEST(CalibrationFile, LensesOfOtherModelsAreRefusedUnlessTheyAreZero) {
  EXPECT_TRUE(lensOf("equidistant", {0, 0, 0, 0}).isNone());
  EXPECT_TRUE(lensOf("", {}).isNone());
  EXPECT_THROW(lensOf("equidistant", {1, 0, 0, 0}), std::invalid_argument);
  EXPECT_THROW(lensOf("plumb_bob", {1, 2, 3}), std::invalid_argument);
  EXPECT_THROW(lensOf("plumb_bob", {1, 2, 3, NAN}), std::invalid_argument);
  EXPECT_THROW(lensOf("", {1, 2, 3, 4, 5, 6, 7, 8, 9, 0, 0, 0}), std::invalid_argument);
  EXPECT_EQ(lensOf("rational_polynomial", {1, 2, 3, 4, 5, 6, 7, 8}).k6, 8);
}

TEST(CalibrationFile, OfTheRecordingCountsIfItIsOfTheSizeOfTheImages) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "depth");
  writePng(folder / "depth/1.5.png", Raster<std::uint16_t>{8, 6, 1, std::vector<std::uint16_t>(48, 1000)});
  putBytes(folder / "a_color.yaml", "image_width: 64\nimage_height: 48\nfx: 70\nfy: 70\ncx: 32\ncy: 24\n");
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder.path()); }), HasSubstr("camera.ini"));
  putBytes(folder / "b_depth.yaml",
           "image_width: 8\nimage_height: 6\nfx: 7\nfy: 7\ncx: 3.5\ncy: 2.5\nk1: 0.1\n");
  const DepthSequence sequence = DepthSequence::open(folder.path());
  EXPECT_EQ(sequence.camera()->camera.intrinsics, (Intrinsics{8, 6, 7, 7, 3.5, 2.5}));
  EXPECT_EQ(sequence.camera()->lens.k1, 0.1);
  EXPECT_THAT(sequence.remark(), HasSubstr("b_depth.yaml"));
}

}  // namespace
}  // namespace facetloc::internal
