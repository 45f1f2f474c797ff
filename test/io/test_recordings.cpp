// SPDX-License-Identifier: BSD-3-Clause
// One recording in all the layouts that people have: the same images, times and poses come out of each.
#include "base/text.h"
#include "temporary_folder.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>

#include <pcl/io/pcd_io.h>

#include <functional>

namespace facetloc::test {
namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr double kPeriod = 1 / 30.0;  // period of recordings that number their images [s]

/** A depth of its own for each image [mm]. */
int millimetres(int number) { return 1000 + 10 * number; }

/** Turns and moves. */
Eigen::Isometry3d poseOf(double number) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(0.01 * number, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  T.translation() << 0.1 * number, 2, -1;
  return T;
}

std::string matrixText(const Eigen::Isometry3d& T) {
  std::string out;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) out += text::significant(T.matrix()(r, c)) + (c == 3 ? "\n" : "\t ");
  return out;
}

class Recordings : public InAFolder {
protected:
  void put(const std::string& name, const std::string& content) const {
    fs::create_directories((folder_ / name).parent_path());
    putBytes(folder_ / name, content);
  }
  void putDepth(const std::string& name, int number, double scale = 1000) const {
    fs::create_directories((folder_ / name).parent_path());
    Raster<std::uint16_t> raster{kWidth, kHeight, 1, {}};
    raster.data.assign(std::size_t(kWidth) * kHeight,
                       static_cast<std::uint16_t>(millimetres(number) * scale / 1000));
    writePng(folder_ / name, raster);
  }
  void putCloud(const std::string& name, int number) const {
    pcl::PointCloud<pcl::PointXYZ> cloud(32, 24);
    const float z = static_cast<float>(millimetres(number)) / 1000;
    for (int v = 0; v < 24; ++v)
      for (int u = 0; u < 32; ++u) cloud(u, v) = {z * float(u - 15.5) / 26, z * float(v - 11.5) / 26, z};
    pcl::io::savePCDFileBinary((folder_ / name).string(), cloud);
  }
  void putPoses(const std::string& name, const std::vector<double>& stamps,
                const std::function<double(double)>& numberOf) const {
    std::vector<StampedPose> poses;
    for (const double stamp : stamps) poses.push_back({stamp, poseOf(numberOf(stamp))});
    writeTumTrajectory(folder_ / name, poses);
  }
  DepthSequence open(const RecordingHints& hints = {}) const {
    return DepthSequence::open(folder_.path(), hints);
  }

  /** The images of these numbers, at these times. */
  static void expectImages(const DepthSequence& sequence, const std::vector<int>& numbers,
                           const std::vector<double>& stamps) {
    ASSERT_EQ(sequence.frames().size(), numbers.size());
    EXPECT_TRUE(sequence.stamped());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      EXPECT_NEAR(sequence.frames()[i].stamp, stamps[i], 1e-6);
      EXPECT_NEAR(*text::to<double>(sequence.frames()[i].name), stamps[i], 1e-6) << "a name is no stamp";
      EXPECT_NEAR(sequence.load(i).depth.at(5), millimetres(numbers[i]) / 1000.0, 1e-4);
    }
  }
  static void expectPose(const DepthSequence& sequence, std::size_t index, const Eigen::Isometry3d& T) {
    const auto found = sequence.groundTruth().at(sequence.frames().at(index).stamp);
    ASSERT_TRUE(found) << index;
    EXPECT_TRUE(found->isApprox(T, 1e-5)) << found->matrix();
  }
};

TEST_F(Recordings, SevenScenes) {
  for (const int n : {3, 12, 4}) {
    const std::string name = "frame-0000" + std::string(n < 10 ? "0" : "") + std::to_string(n);
    putDepth(name + ".depth.png", n);
    writePng(folder_ / (name + ".color.png"), Raster<std::uint8_t>{1, 1, 3, {1, 2, 3}});
    if (n != 4) put(name + ".pose.txt", matrixText(poseOf(n)));
  }
  const DepthSequence sequence = open();
  expectImages(sequence, {3, 4, 12}, {3 * kPeriod, 4 * kPeriod, 12 * kPeriod});
  expectPose(sequence, 0, poseOf(3));
  expectPose(sequence, 2, poseOf(12));
  EXPECT_FALSE(sequence.groundTruth().at(sequence.frames()[1].stamp));
  EXPECT_EQ(sequence.camera()->camera.intrinsics, (Intrinsics{640, 480, 585, 585, 320, 240}));
  EXPECT_THAT(sequence.remark(), HasAll("no camera.ini", "7-Scenes"));
  EXPECT_EQ(DepthSequence::readTruth(folder_.path()).poses().size(), 2u);
}

TEST_F(Recordings, FilesOfOnePoseHaveTheNumbersOfTheirImages) {
  for (const char* name : {"%_pose.txt", "pose-%.txt", "camera %.txt"}) {
    const TemporaryFolder folder;
    putBytes(folder / "camera.ini", "width=640 height=480 fx=525 fy=525 cx=319.5 cy=239.5 depth_scale=1000");
    for (const int n : {1, 2, 10}) {
      const std::string number = (n < 10 ? "00" : "0") + std::to_string(n);
      std::string file = name;
      file.replace(file.find('%'), 1, number);
      putBytes(folder / file, matrixText(poseOf(n)));
      writePng(folder / (number + "_depth.png"), Raster<std::uint16_t>{2, 2, 1, {1000, 1000, 1000, 1000}});
    }
    const DepthSequence sequence = DepthSequence::open(folder.path());
    EXPECT_EQ(sequence.groundTruth().poses().size(), 3u) << name;
    expectPose(sequence, 2, poseOf(10));
  }
}

TEST_F(Recordings, ImagesOfSeveralCamerasAreNoRecording) {
  for (const auto& [first, second] : {std::pair("cam0_", "cam1_"),
                                      {"left-", "right-"},
                                      {"1-2-3-4-5-6-7-8-9-10-11-12-13-14-15-16-17-18-left-",
                                       "1-2-3-4-5-6-7-8-9-10-11-12-13-14-15-16-17-18-right-"}}) {
    const TemporaryFolder folder;
    putBytes(folder / "camera.ini", "width=640 height=480 fx=525 fy=525 cx=319.5 cy=239.5 depth_scale=1000");
    for (const char* time : {"0.0", "0.5", "1.0"})
      for (const char* camera : {first, second})
        writePng(folder / (std::string(camera) + time + ".png"),
                 Raster<std::uint16_t>{2, 2, 1, {1, 1, 1, 1}});
    EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder.path()); }),
                HasAll("images of 2 cameras", first, second));
  }
  for (const char* name : {"10-00-01.5.png", "10-00-02.5.png", "11-00-01.5.png", "11-00-03.5.png"})
    putDepth(name, 1);
  put("camera.ini", "width=640 height=480 fx=525 fy=525 cx=319.5 cy=239.5 depth_scale=1000");
  EXPECT_EQ(open().frames().size(), 4u) << "hours and minutes are no cameras";
  const TemporaryFolder folder;
  putBytes(folder / "camera.ini", "width=640 height=480 fx=525 fy=525 cx=319.5 cy=239.5 depth_scale=1000");
  for (const char* seconds : {"1000", "1001", "1002", "1003"})
    for (const char* nanoseconds : {"_000000000", "_500000000"})
      writePng(folder / (std::string(seconds) + nanoseconds + ".png"),
               Raster<std::uint16_t>{2, 2, 1, {1, 1, 1, 1}});
  EXPECT_EQ(DepthSequence::open(folder.path()).frames().size(), 8u) << "nor are seconds and nanoseconds";
}

TEST_F(Recordings, AMatrixOfIntrinsicsIsACamera) {
  putDepth("seq-01/frame-000001.depth.png", 1);
  put("camera-intrinsics.txt", "570.5\t 0 320.25\n0 571 240.5\n0 0 1\n");
  const DepthSequence sequence = DepthSequence::open(folder_ / "seq-01");
  EXPECT_EQ(sequence.camera()->camera.intrinsics, (Intrinsics{640, 480, 570.5, 571, 320.25, 240.5}));
  EXPECT_THAT(sequence.remark(), HasSubstr("camera-intrinsics.txt"));
  for (const char* matrix : {"1 2 3", "570 0 320 0 x 240 0 0 1", "0 0 320 0 0 240 0 0 1", ""}) {
    put("camera-intrinsics.txt", matrix);
    EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder_ / "seq-01"); }),
                HasSubstr("camera-intrinsics.txt"));
  }
}

TEST_F(Recordings, ScanNet) {
  for (const int n : {0, 7, 10}) putDepth("depth/" + std::to_string(n) + ".png", n);
  put("pose/0.txt", matrixText(poseOf(0)));
  put("pose/7.txt", "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n");
  put("pose/10.txt", matrixText(poseOf(10)));
  put("intrinsic/intrinsic_depth.txt", "577.6 0 318.9 0 0 578.7 242.7 0 0 0 1 0 0 0 0 1");
  const DepthSequence sequence = open();
  expectImages(sequence, {0, 7, 10}, {0, 7 * kPeriod, 10 * kPeriod});
  expectPose(sequence, 0, poseOf(0));
  expectPose(sequence, 2, poseOf(10));
  EXPECT_EQ(sequence.groundTruth().poses().size(), 2u) << "a lost pose counts as one";
  EXPECT_EQ(sequence.camera()->camera.intrinsics, (Intrinsics{640, 480, 577.6, 578.7, 318.9, 242.7}));
}

TEST_F(Recordings, FilesOfOnePoseThatAreBroken) {
  putDepth("depth/0.png", 0);
  put("camera.ini", "width=640 height=480 fx=525 fy=525 cx=319.5 cy=239.5 depth_scale=1000");
  for (const std::string& broken :
       {std::string("1 0 0"), matrixText(poseOf(1)) + " 1", std::string("1 0 0 0 0 x"),
        "2 " + matrixText(poseOf(0)).substr(2), "1 0 0 2e7 0 1 0 0 0 0 1 0 0 0 0 " + std::string("1")}) {
    put("pose/0.txt", broken);
    const DepthSequence sequence = open();
    EXPECT_FALSE(sequence.load(0).empty());
    EXPECT_THAT(ioErrorOf([&] { sequence.groundTruth(); }), HasSubstr("0.txt")) << broken;
  }
}

TEST_F(Recordings, IclNuim) {
  for (const int n : {0, 1, 2}) putDepth("depth/" + std::to_string(n) + ".png", n, 5000);
  // Stamps are numbers; the camera's y axis points up, so that in its world left and right are exchanged.
  const Eigen::Matrix4d mirror = Eigen::Vector4d(1, -1, 1, 1).asDiagonal();
  std::vector<StampedPose> poses;
  for (const int n : {1, 2})
    poses.push_back({double(n), Eigen::Isometry3d(mirror * poseOf(n).matrix() * mirror)});
  writeTumTrajectory(folder_ / "traj3n.gt.freiburg", poses);
  const DepthSequence sequence = open();
  expectImages(sequence, {0, 1, 2}, {0, kPeriod, 2 * kPeriod});
  expectPose(sequence, 1, poseOf(1));
  expectPose(sequence, 2, poseOf(2));
  EXPECT_EQ(sequence.camera()->camera.intrinsics.fy, 480);
  EXPECT_THAT(sequence.remark(), HasSubstr("ICL-NUIM"));
}

TEST_F(Recordings, AnUprightCameraOfTheLayoutOfIclIsTakenAsItIs) {
  putDepth("depth/1.png", 1);
  putPoses("a.gt.freiburg", {1}, [](double n) { return n; });
  put("camera.ini", "width=640 height=480 fx=525 fy=525 cx=319.5 cy=239.5 depth_scale=1000");
  expectPose(open(), 0, poseOf(1));
}

TEST_F(Recordings, TumAsDownloaded) {
  const fs::path root = folder_ / "rgbd_dataset_freiburg3_structure";
  for (const int n : {1, 2})
    putDepth("rgbd_dataset_freiburg3_structure/depth/100." + std::to_string(n) + "00000.png", n, 5000);
  put("rgbd_dataset_freiburg3_structure/depth.txt", "# depth maps\n100.100000 depth/100.100000.png\n");
  // At stamps of its own: a pose each 0.04 s.
  const auto numberOf = [](double stamp) { return 10 * (stamp - 100); };
  putPoses("rgbd_dataset_freiburg3_structure/groundtruth.txt", {100.08, 100.12, 100.16, 100.2}, numberOf);
  const DepthSequence sequence = DepthSequence::open(root);
  expectImages(sequence, {1, 2}, {100.1, 100.2});
  EXPECT_EQ(sequence.frames()[0].name, "100.100000");
  expectPose(sequence, 0, poseOf(1));  // interpolated
  expectPose(sequence, 1, poseOf(2));
  EXPECT_EQ(sequence.camera()->camera.intrinsics.fx, 535.4);
  EXPECT_EQ(sequence.camera()->preset, "xtion");
  EXPECT_THAT(sequence.remark(), HasSubstr("freiburg3"));
}

TEST_F(Recordings, AListNextToImagesHasTheirTimes) {
  for (const char* name : {"a", "b", "c"}) putDepth("depth/" + std::string(name) + ".png", *name - 'a', 5000);
  put("camera.ini", "width=640 height=480 fx=525 fy=525 cx=319.5 cy=239.5 depth_scale=5000");
  put("associations.txt", "7.5 rgb/x.png 7.25 depth/b.png\n5 depth/a.png 5.01 rgb/y.png\n");
  expectImages(open(), {0, 1}, {5, 7.25});
  put("depth.txt", "# stamp file\n9 depth/a.png\n8 depth/c.png\n");
  expectImages(open(), {2, 0}, {8, 9});
  expectImages(DepthSequence::open(folder_ / "associations.txt"), {0, 1}, {5, 7.25});
  put("depth.txt", "9 depth/a.png\ndepth/c.png\n");
  EXPECT_THAT(ioErrorOf([&] { open(); }), HasAll("depth.txt", "line 2"));
  put("depth.txt", "9 a.png 9 b.png\n");
  EXPECT_THAT(ioErrorOf([&] { open(); }), HasAll("line 1", "called depth"));
}

TEST_F(Recordings, PclsRecordersHaveTimesInTheNames) {
  putCloud("frame_20121214T142255.814212.pcd", 1);
  putCloud("frame_20121214T142256.pcd", 2);
  constexpr double kTime = 1355494975;  // 2012-12-14 14:22:55 UTC
  putPoses("groundtruth.txt", {kTime + 0.814212, kTime + 1}, [&](double stamp) { return stamp - kTime; });
  const DepthSequence sequence = open();
  expectImages(sequence, {1, 2}, {kTime + 0.814212, kTime + 1});
  EXPECT_EQ(sequence.frames()[0].name, "1355494975.814212");
  expectPose(sequence, 0, poseOf(0.814212));
}

TEST_F(Recordings, DatesOfAllUsualFormsAreTimes) {
  constexpr double kTime = 1684059213;  // 2023-05-14 10:13:33 UTC
  for (const auto& [first, second, third] :
       {std::tuple("2023-05-14-10-13-33", "2023-05-14-10-14-05", "2023-05-14-10-15-04"),
        {"2023-05-14_10-13-33", "2023-05-14_10-14-05", "2023-05-14_10-15-04"},
        {"2023.05.14 10:13:33", "2023.05.14 10:14:05", "2023.05.14 10:15:04"},
        {"cam_20230514_101333_depth", "cam_20230514_101405_depth", "cam_20230514_101504_depth"},
        {"20230514101333", "20230514101405", "20230514101504"}}) {
    fs::remove_all(folder_ / "clouds");
    fs::create_directory(folder_ / "clouds");
    for (const char* name : {first, second, third}) putCloud(std::string("clouds/") + name + ".pcd", 1);
    const DepthSequence sequence = DepthSequence::open(folder_ / "clouds");
    ASSERT_TRUE(sequence.stamped()) << first;
    EXPECT_EQ(sequence.frames().front().stamp, kTime) << first;
    EXPECT_EQ(sequence.frames().back().stamp, kTime + 91) << first;
  }
}

TEST_F(Recordings, NamesThatOnlyResembleTimesAreNotTimes) {
  for (const char* name : {"frame_20121314T142255.814212", "frame_20121214T142255.8e5", "a_20121214T1422",
                           "20121214T142255.81421x", "frame_2012-12-14T14"}) {
    fs::remove_all(folder_ / "clouds");
    fs::create_directory(folder_ / "clouds");
    putCloud(std::string("clouds/") + name + ".pcd", 1);
    EXPECT_FALSE(DepthSequence::open(folder_ / "clouds").stamped()) << name;
  }
}

TEST_F(Recordings, AListMayHaveANameOfAnyLength) {
  put("camera.ini", "width=640 height=480 fx=525 fy=525 cx=319.5 cy=239.5 depth_scale=1000");
  put("list.txt", "20121214T" + std::string(200000, '_') + "142255.png\n");
  const DepthSequence sequence = DepthSequence::open(folder_ / "list.txt");
  ASSERT_EQ(sequence.frames().size(), 1u);
  EXPECT_THROW(sequence.load(0), IoError);
}

TEST_F(Recordings, ImagesOfAnUnknownCameraAreAnErrorThatNamesTheRemedy) {
  putDepth("depth/1.5.png", 1);
  const std::string error = ioErrorOf([&] { open(); });
  EXPECT_THAT(error, HasAll("camera.ini", "--camera NAME", "realsense_d435"));
  // The lines between are a camera.ini.
  std::string lines;
  for (const auto line : text::lines(error))
    if (line.substr(0, 2) == "  ") lines += std::string(line) + "\n";
  put("camera.ini", lines);
  expectImages(open(), {1}, {1.5});
  EXPECT_NEAR(open().camera()->camera.intrinsics.fx, kinectIntrinsics().fx, 0.5);
  EXPECT_EQ(open().camera()->preset, "kinect");
}

TEST_F(Recordings, ACameraThatIsNamedHasATypicalDevicesIntrinsics) {
  putDepth("depth/1.5.png", 1);
  RecordingHints hints;
  hints.camera = "realsense_d435";
  const DepthSequence sequence = open(hints);
  expectImages(sequence, {1}, {1.5});
  const CameraPreset& preset = *findCameraPreset("realsense_d435");
  EXPECT_EQ(sequence.camera()->camera.intrinsics, preset.intrinsics());
  EXPECT_EQ(sequence.camera()->camera.max_depth, preset.max_depth);
  EXPECT_THAT(sequence.remark(), HasSubstr("typical"));
  hints.camera = "azure_kinect";  // its images are of another shape
  EXPECT_THAT(ioErrorOf([&] { open(hints); }), HasAll("640x480", "640x576"));
  hints.camera = "webcam";
  EXPECT_THAT(ioErrorOf([&] { open(hints); }), HasAll("webcam", "kinect, xtion"));
}

TEST_F(Recordings, SmallerImagesHaveATypicalDevicesFieldOfView) {
  Raster<std::uint16_t> raster{320, 240, 1, std::vector<std::uint16_t>(320 * 240, 1000)};
  writePng(folder_ / "1.png", raster);
  RecordingHints hints;
  hints.camera = "kinect";
  const Intrinsics k = open(hints).camera()->camera.intrinsics, full = kinectIntrinsics();
  EXPECT_EQ(k.width, 320);
  for (const auto& [u, v] :
       {std::pair(0.0, 0.0), std::pair(320.0, 240.0)}) {  // corners, not centres of pixels
    EXPECT_NEAR((u - 0.5 - k.cx) / k.fx, (2 * u - 0.5 - full.cx) / full.fx, 1e-12);
    EXPECT_NEAR((v - 0.5 - k.cy) / k.fy, (2 * v - 0.5 - full.cy) / full.fy, 1e-12);
  }
}

TEST_F(Recordings, ACameraThatIsNamedHasItsModes) {
  Raster<std::uint16_t> raster{480, 848, 1, std::vector<std::uint16_t>(480 * 848, 1000)};
  writePng(folder_ / "1.png", raster);
  EXPECT_THAT(ioErrorOf([&] { open(); }), HasAll("camera=realsense_d435", "fx=425"));
  RecordingHints hints;
  hints.camera = "realsense_d435";
  const Intrinsics k = open(hints).camera()->camera.intrinsics;
  EXPECT_EQ(k, *findCameraPreset("realsense_d435")->intrinsicsOf(480, 848));
  EXPECT_EQ(k.fx, 425);
}

TEST_F(Recordings, WhatTheUserSaysCountsMoreThanTheFiles) {
  putDepth("depth/1.5.png", 1, 5000);
  put("camera.ini", "width=640 height=480 fx=500 fy=501 cx=319.5 cy=239.5 depth_scale=1000 mount_height=1 "
                    "mount_tilt_deg=5");
  RecordingHints hints;
  hints.depth_scale = 5000;
  expectImages(open(hints), {1}, {1.5});
  hints.camera = "phone_lidar";  // its range, with the calibration that is there
  const Camera camera = open(hints).camera()->camera;
  EXPECT_EQ(camera.intrinsics.fx, 500);
  EXPECT_EQ(camera.mounting->height, 1);
  EXPECT_EQ(camera.max_depth, 5);
  put("other.ini", "width=640 height=480 fx=600 fy=600 cx=319.5 cy=239.5 depth_scale=2500");
  hints = {(folder_ / "other.ini").string(), 0, 0};
  EXPECT_EQ(open(hints).camera()->camera.intrinsics.fx, 600);
  EXPECT_EQ(open(hints).camera()->depth_scale, 2500);
}

TEST_F(Recordings, ADepthScaleIsOfPngs) {
  putCloud("1.pcd", 1);
  RecordingHints hints;
  hints.depth_scale = 5000;
  EXPECT_THAT(ioErrorOf([&] { open(hints); }), HasSubstr("no PNG images"));
  hints = {"realsense_d435", 0, 0};  // a cloud has its intrinsics in it
  const DepthSequence sequence = open(hints);
  EXPECT_EQ(sequence.camera()->camera.max_depth, 6);
  EXPECT_NEAR(sequence.load(0).camera.fx, 26, 0.01);
}

TEST_F(Recordings, PosesAreLookedUpAtTheTimesOfTheImages) {
  putDepth("depth/10.png", 1);
  put("camera.ini", "width=640 height=480 fx=525 fy=525 cx=319.5 cy=239.5 depth_scale=1000");
  putPoses("groundtruth.txt", {10, 12}, [](double stamp) { return stamp; });
  RecordingHints hints;
  hints.time_offset = 2;
  expectPose(open(), 0, poseOf(10));
  expectPose(open(hints), 0, poseOf(12));
  EXPECT_EQ(open(hints).readPoses(folder_ / "groundtruth.txt").poses()[1].stamp, 10);
  EXPECT_EQ(DepthSequence::readTruth(folder_.path(), 2).poses()[1].stamp, 10);
  EXPECT_EQ(DepthSequence::readTruth(folder_ / "groundtruth.txt", 2).poses()[1].stamp, 10);
}

TEST_F(Recordings, TruePosesAreReadWithoutImagesOrTheirCamera) {
  putPoses("groundtruth.txt", {10, 12}, [](double stamp) { return stamp; });
  EXPECT_EQ(DepthSequence::readTruth(folder_.path()).poses().size(), 2u);
  putDepth("depth/10.png", 1);
  EXPECT_EQ(DepthSequence::readTruth(folder_.path()).poses().size(), 2u);
  EXPECT_THAT(DepthSequence::readTruth(TemporaryFolder().path()).poses(), IsEmpty());
}

}  // namespace
}  // namespace facetloc::test
