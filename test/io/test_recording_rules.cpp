// SPDX-License-Identifier: BSD-3-Clause
// Recordings with unknown folders and names: files found, assumptions made, and
// refusals.
#include "base/text.h"
#include "temporary_folder.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>

namespace facetloc::test {
namespace {

constexpr const char* kCamera = "width=8 height=6 fx=7 fy=7 cx=3.5 cy=2.5 depth_scale=1000\n";

class Rules : public InAFolder {
protected:
  void putDepth(const std::string& name, std::uint16_t millimetres = 1000) const {
    fs::create_directories((folder_ / name).parent_path());
    writePng(folder_ / name, Raster<std::uint16_t>{8, 6, 1, std::vector<std::uint16_t>(48, millimetres)});
  }
  void putPicture(const std::string& name, int channels = 3) const {
    fs::create_directories((folder_ / name).parent_path());
    writePng(folder_ / name,
             Raster<std::uint8_t>{8, 6, channels,
                                  std::vector<std::uint8_t>(static_cast<std::size_t>(48 * channels))});
  }
  void put(const std::string& name, const std::string& text) const { putBytes(folder_ / name, text); }
  DepthSequence open(const std::string& name = "") const { return DepthSequence::open(folder_ / name); }
  std::string errorOf(const std::string& name = "") const {
    return ioErrorOf([&] { open(name); });
  }
  static std::vector<double> stampsOf(const DepthSequence& sequence) {
    std::vector<double> stamps;
    for (const FrameFile& frame : sequence.frames()) stamps.push_back(frame.stamp);
    return stamps;
  }
  static std::vector<float> depthsOf(const DepthSequence& sequence) {
    std::vector<float> depths;
    for (std::size_t i = 0; i < sequence.frames().size(); ++i) depths.push_back(sequence.load(i).depth.at(0));
    return depths;
  }
};

TEST_F(Rules, TheOnlyFolderWithDepthInItsNameHasTheImages) {
  for (const char* name :
       {"aligned_depth", "Depth", "depth_registered", "lowres_depth", "scan/depth_images"}) {
    const TemporaryFolder folder;
    fs::create_directories(folder / name);
    writePng(folder / (std::string(name) + "/1.500000.png"),
             Raster<std::uint16_t>{8, 6, 1, std::vector<std::uint16_t>(48, 1000)});
    fs::create_directories(folder / "color");
    writePng(folder / "color/1.500000.png", Raster<std::uint8_t>{8, 6, 3, std::vector<std::uint8_t>(144)});
    putBytes(folder / "camera.ini", kCamera);
    EXPECT_EQ(DepthSequence::open(folder.path()).frames().size(), 1u) << name;
  }
}

TEST_F(Rules, PicturesOfDepthAreNoDepthImages) {
  put("camera.ini", kCamera);
  putDepth("raw_depth/1.5.png");
  putPicture("depth_colorized/1.5.png");
  EXPECT_EQ(open().frames()[0].path.parent_path().filename(), "raw_depth");
}

TEST_F(Rules, OfSeveralFoldersOneHasToBeNamed) {
  put("camera.ini", kCamera);
  putDepth("lowres_depth/1.5.png"), putDepth("highres_depth/1.5.png");
  EXPECT_THAT(errorOf(), HasAll("lowres_depth", "highres_depth", "name one"));
  EXPECT_EQ(open("lowres_depth").frames().size(), 1u);
}

TEST_F(Rules, ImagesWithDepthInTheirNamesCount) {
  for (const auto& [depth, other] : {std::pair("000000-depth.png", "000000-color.png"),
                                     {"depth_00000.png", "conf_00000.png"},
                                     {"frame-0.Depth.png", "frame-0.color.png"},
                                     {"depth000000.png", "frame000000.png"}}) {
    const TemporaryFolder folder;
    const Raster<std::uint16_t> raster{8, 6, 1, std::vector<std::uint16_t>(48, 1000)};
    writePng(folder / depth, raster);
    writePng(folder / other, Raster<std::uint8_t>{8, 6, 3, std::vector<std::uint8_t>(144)});
    putBytes(folder / "camera.ini", kCamera);
    const DepthSequence sequence = DepthSequence::open(folder.path());
    ASSERT_EQ(sequence.frames().size(), 1u) << depth;
    EXPECT_EQ(sequence.frames()[0].path.filename(), depth);
  }
}

TEST_F(Rules, ImagesOfConfidenceAreNotDepth) {
  put("camera.ini", kCamera);
  putDepth("1.5.png");
  putPicture("conf_1.5.png", 1);
  EXPECT_EQ(open().frames().size(), 1u);
}

TEST_F(Rules, NumbersAnywhereInNamesOrderTheImages) {
  put("camera.ini", kCamera);
  for (const int n : {2, 10, 1})
    putDepth("depth_" + std::to_string(n) + "_raw.png", static_cast<std::uint16_t>(1000 * n));
  const DepthSequence sequence = open();
  EXPECT_THAT(depthsOf(sequence), ElementsAre(1, 2, 10));
  EXPECT_TRUE(sequence.stamped());
  EXPECT_NEAR(sequence.frames()[2].stamp, 10 / 30.0, 1e-9);
  EXPECT_THAT(sequence.remark(), HasSubstr("only numbered"));
  EXPECT_FALSE(sequence.timed()) << "at an assumed rate";
}

TEST_F(Rules, TimesAnywhereInNamesAreTimes) {
  put("camera.ini", kCamera);
  putDepth("1721362630.651355_depth.png", 1000), putDepth("1721362630.751355_depth.png", 2000);
  EXPECT_NEAR(open().frames()[1].stamp, 1721362630.751355, 1e-6);
  EXPECT_EQ(open().frames()[0].name, "1721362630.651355");
}

TEST_F(Rules, StampsInOtherUnitsAreKnownByTheirSize) {
  for (const auto& [first, second, unit] : {std::tuple("1700000000000", "1700000000100", "milliseconds"),
                                            {"1700000000000000", "1700000000100000", "microseconds"},
                                            {"1700000000000000000", "1700000000100000000", "nanoseconds"}}) {
    const TemporaryFolder folder;
    for (const char* name : {first, second})
      writePng(folder / (std::string(name) + ".png"),
               Raster<std::uint16_t>{8, 6, 1, std::vector<std::uint16_t>(48, 1000)});
    putBytes(folder / "camera.ini", kCamera);
    putBytes(folder / "groundtruth.txt",
             std::string(first) + " 0 0 0 0 0 0 1\n" + second + " 1 0 0 0 0 0 1\n");
    const DepthSequence sequence = DepthSequence::open(folder.path());
    EXPECT_THAT(stampsOf(sequence), ElementsAre(DoubleNear(1.7e9, 1e-6), DoubleNear(1.7e9 + 0.1, 1e-6)))
        << unit;
    EXPECT_EQ(sequence.frames()[1].name, "1700000000.100000");
    EXPECT_THAT(sequence.remark(), HasSubstr(unit));
    EXPECT_NEAR(sequence.groundTruth().at(1.7e9 + 0.1)->translation().x(), 1, 1e-4) << unit;
  }
}

TEST_F(Rules, MillisecondsSinceTheStartAreRecognizedByTheirJitter) {
  put("camera.ini", kCamera);
  for (const int ms : {0, 33, 67, 100, 133, 167}) putDepth("depth/" + std::to_string(ms) + ".png");
  EXPECT_NEAR(open().frames()[2].stamp, 0.067, 1e-9);
}

TEST_F(Rules, CountedImagesWithoutPosesAreAThirtiethApart) {
  put("camera.ini", kCamera);
  for (const int n : {7, 8, 9}) putDepth("depth/" + std::to_string(n) + ".png");
  EXPECT_NEAR(open().frames()[1].stamp, 8 / 30.0, 1e-9);
  EXPECT_THAT(open().remark(), HasSubstr("1/30 s apart"));
}

TEST_F(Rules, CountedImagesWithAsManyTimesTakeTheseInTheirOrder) {
  put("camera.ini", kCamera);
  for (const int n : {0, 1, 2, 3}) putDepth("depth/00000" + std::to_string(n) + ".png");
  const auto pose = [](double stamp, int x) {
    return text::shortest(stamp) + " " + std::to_string(x) + " 0 0 0 0 0 1\n";
  };
  put("groundtruth.txt", pose(0, 0) + pose(0.11, 1) + pose(0.22, 2) + pose(0.34, 3));
  const DepthSequence sequence = open();
  EXPECT_THAT(stampsOf(sequence), ElementsAre(0, 0.11, 0.22, 0.34));
  EXPECT_EQ(sequence.groundTruth().at(0.34)->translation().x(), 3);
  EXPECT_THAT(sequence.remark(), HasSubstr("in their order"));
  put("groundtruth.txt", pose(0, 0) + pose(0.11, 1) + pose(0.22, 2) + pose(0.34, 3) + pose(0.44, 4));
  EXPECT_THAT(ioErrorOf([&] { open().groundTruth(); }), HasSubstr("they cannot be assigned to each other"));
}

TEST_F(Rules, CountedImagesWithTheirNumbersKeepThese) {
  put("camera.ini", kCamera);
  for (const int n : {10, 11, 12}) putDepth("depth/" + std::to_string(n) + ".png");
  put("groundtruth.txt", "10 0 0 0 0 0 0 1\n11 1 0 0 0 0 0 1\n12 2 0 0 0 0 0 1\n13 3 0 0 0 0 0 1\n");
  EXPECT_THAT(stampsOf(open()), ElementsAre(10, 11, 12));
  EXPECT_EQ(open().groundTruth().at(11)->translation().x(), 1);
}

TEST_F(Rules, AListNextToCountedImagesHasTheirTimes) {
  put("camera.ini", kCamera);
  putDepth("depth/1.png", 1000), putDepth("depth/2.png", 2000);
  put("depth.txt", "5.25 depth/2.png\n5.5 depth/1.png\n");
  EXPECT_THAT(stampsOf(open()), ElementsAre(5.25, 5.5));
  EXPECT_THAT(depthsOf(open()), ElementsAre(2, 1));
}

TEST_F(Rules, ListsAsPeopleHaveThem) {
  put("camera.ini", kCamera);
  putDepth("depth/a.png", 1000), putDepth("depth/b.png", 2000);
  const auto depths = [&](const std::string& text) {
    put("list.txt", text);
    return depthsOf(open("list.txt"));
  };
  const std::string good = "0.5 rgb/b.png 0.5 depth/b.png\n";
  EXPECT_THAT(depths("0.0 rgb/a.png 0.0 depth/a.png\n0.1 rgb/x.png 0.0 depth/a.png\n" + good),
              ElementsAre(1, 2));
  EXPECT_THAT(depths("0.0 depth\\a.png\n0.5 depth\\b.png\n"), ElementsAre(1, 2));
  EXPECT_THAT(depths("timestamp,filename\n0.0,depth/a.png\n0.5,depth/b.png\n"), ElementsAre(1, 2));
  EXPECT_THAT(
      depths("0.0 rgb/a.jpg 0.0 depth/a.png 0.0 mask/a.png\n0.5 rgb/b.jpg 0.5 depth/b.png 0.5 mask/b.png\n"),
      ElementsAre(1, 2));
  EXPECT_THAT(depths("rgb/a.jpg depth/a.png\nrgb/b.jpg depth/b.png\n"), ElementsAre(1, 2));
  putDepth("a b.png", 3000);
  EXPECT_THAT(depths("a b.png\n"), ElementsAre(3));
  put("list.txt", "0.0 x/a.png 0.0 y/a.png\n");
  EXPECT_THAT(errorOf("list.txt"), HasAll("line 1", "called depth"));
}

TEST_F(Rules, ThePosesOfAListAreThoseOfItsImages) {
  put("camera.ini", kCamera);
  putDepth("depth/a.png"), putDepth("depth/b.png");
  for (
      const char* text :
      {"0.01 1 2 3 0 0 0 1 0.0 depth/a.png 0.0 rgb/a.png\n0.51 4 5 6 0 0 0 1 0.5 depth/b.png 0.5 rgb/b.png\n",
       "0.0 rgb/a.png 0.0 depth/a.png 0.01 1 2 3 0 0 0 1\n0.5 rgb/b.png 0.5 depth/b.png 0.51 4 5 6 0 0 0 1\n",
       "0.0 depth/a.png 1 2 3 0 0 0 1\n0.5 depth/b.png 4 5 6 0 0 0 1\n"}) {
    put("list.txt", text);
    const DepthSequence sequence = open("list.txt");
    ASSERT_EQ(sequence.groundTruth().poses().size(), 2u) << text;
    EXPECT_EQ(sequence.groundTruth().at(0.5)->translation(), Eigen::Vector3d(4, 5, 6));
  }
}

TEST_F(Rules, PosesOfAnyNameInTheRecordingAreFound) {
  for (const char* name :
       {"walk_camera_poses.txt", "CameraTrajectory.txt", "traj.txt", "poses.csv", "odometry.csv"}) {
    const TemporaryFolder folder;
    fs::create_directories(folder / "depth");
    writePng(folder / "depth/1.5.png", Raster<std::uint16_t>{8, 6, 1, std::vector<std::uint16_t>(48, 1000)});
    putBytes(folder / "camera.ini", kCamera);
    putBytes(folder / "poses_are_missing.txt", "sorry\n");
    putBytes(folder / name, "1.5 1 2 3 0 0 0 1\n1.6 1 2 3 0 0 0 1\n");
    const DepthSequence sequence = DepthSequence::open(folder.path());
    EXPECT_EQ(sequence.groundTruth().poses().size(), 2u) << name;
    EXPECT_THAT(sequence.remark(), HasSubstr(name));
    putBytes(folder / "groundtruth.txt", "1.5 1 2 3 0 0 0 1\n");
    EXPECT_EQ(DepthSequence::open(folder.path()).groundTruth().poses().size(), 1u) << name;
  }
}

TEST_F(Rules, PosesOfAnotherConventionAreReadAsTheUserSays) {
  put("camera.ini", kCamera);
  putDepth("depth/1.5.png");
  put("groundtruth.txt", "1.5 1 2 3 0 0 0 1\n");
  RecordingHints hints;
  hints.poses_are = "inverse";
  const auto T = DepthSequence::open(folder_.path(), hints).groundTruth().poses()[0].T_w_c;
  EXPECT_EQ(T.translation(), Eigen::Vector3d(-1, -2, -3));
}

TEST_F(Rules, ALibraryOfReplica) {
  putDepth("office0/results/depth000000.png", 6554), putDepth("office0/results/depth000001.png", 6554);
  putBytes(folder_ / "office0/results/frame000000.jpg", "a picture");
  put("cam_params.json", "{\"camera\": {\"w\": 8, \"h\": 6, \"fx\": 7.0, \"fy\": 7.5, \"cx\": 3.5, \"cy\": "
                         "2.5, \"scale\": 6553.5}}");
  put("office0/traj.txt", "1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1\n1 0 0 7 0 1 0 8 0 0 1 9 0 0 0 1\n");
  const DepthSequence sequence = open("office0");
  ASSERT_EQ(sequence.frames().size(), 2u);
  EXPECT_NEAR(sequence.load(0).depth[0], 1, 1e-3);
  EXPECT_EQ(sequence.camera()->camera.intrinsics.fy, 7.5);
  EXPECT_EQ(sequence.groundTruth().at(sequence.frames()[1].stamp)->translation(), Eigen::Vector3d(7, 8, 9));
}

TEST_F(Rules, PosesInAFolderOfTheirOwnHaveTheNamesOfTheImages) {
  put("camera.ini", kCamera);
  putDepth("depth/frame_000003.png"), putDepth("depth/frame_000004.png");
  put("poses/frame_000003.txt", "1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1\n");
  const DepthSequence sequence = open();
  ASSERT_EQ(sequence.groundTruth().poses().size(), 1u);
  EXPECT_EQ(sequence.groundTruth().at(sequence.frames()[0].stamp)->translation(), Eigen::Vector3d(4, 5, 6));
}

TEST_F(Rules, APhonesScan) {
  putDepth("depth/000000.png", 1500), putDepth("depth/000001.png", 1500);
  putPicture("confidence/000000.png", 1);
  put("camera_matrix.csv", "1600.0,0.0,960.0\n0.0,1600.0,720.0\n0.0,0.0,1.0\n");
  put("odometry.csv", "timestamp, frame, x, y, z, qx, qy, qz, qw\n100.1, 000000, 1, 2, 3, 0, 0, 0, 1\n100.2, "
                      "000001, 4, 5, 6, 0, 0, 0, 1\n");
  const DepthSequence sequence = open();
  EXPECT_EQ(sequence.camera()->preset, "phone_lidar");
  EXPECT_NEAR(sequence.camera()->camera.intrinsics.fx, 1600 * 8 / 1920.0, 1e-9);
  EXPECT_THAT(stampsOf(sequence), ElementsAre(100.1, 100.2));
  EXPECT_EQ(sequence.groundTruth().at(100.2)->translation(), Eigen::Vector3d(4, 5, 6));
}

TEST_F(Rules, AnotherPhonesScan) {
  putDepth("depth_00000.png", 1500);
  putPicture("conf_00000.png", 1);
  put("frame_00000.json", "{\"time\": 1.5, \"intrinsics\": [1600, 0, 960, 0, 1600, 720, 0, 0, 1]}");
  EXPECT_NEAR(open().camera()->camera.intrinsics.fx, 1600 * 8 / 1920.0, 1e-9);
  EXPECT_EQ(open().frames().size(), 1u);
}

/** A frame of the 3D Scanner App. */
std::string frameJson(int i, const std::string& intrinsics = "[1600, 0, 960, 0, 1600, 720, 0, 0, 1]") {
  return "{\"cameraPoseARFrame\": [1, 0, 0, " + std::to_string(i) +
         ", 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1], \"time\": " + std::to_string(100 + i) +
         ".25, \"intrinsics\": " + intrinsics + ", \"frame_index\": 7}";
}

TEST_F(Rules, JsonBesideEachImageHasItsTimePoseAndCamera) {
  for (int i = 0; i < 3; ++i) {
    putDepth("depth_0000" + std::to_string(i) + ".png", 1500);
    put("frame_0000" + std::to_string(i) + ".json", frameJson(i));
  }
  const DepthSequence sequence = open();
  EXPECT_THAT(stampsOf(sequence), ElementsAre(100.25, 101.25, 102.25));
  EXPECT_NEAR(sequence.camera()->camera.intrinsics.fx, 1600 * 8 / 1920.0, 1e-9);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear().diagonal() = Eigen::Vector3d(1, -1, -1);  // y down, z forward
  T.translation() = Eigen::Vector3d(1, 2, 3);
  EXPECT_TRUE(sequence.groundTruth().at(101.25)->isApprox(T, 1e-9));
  EXPECT_THAT(sequence.remark(), HasSubstr("times and poses of the images are those of frame_00000.json"));
  EXPECT_THAT(sequence.remark(), Not(HasSubstr("only numbered")));
}

TEST_F(Rules, TheSizeOfTheColourImageScalesItsIntrinsics) {
  putDepth("depth_00000.png");
  put("frame_00000.json", frameJson(0, "[800, 0, 480, 0, 800, 360, 0, 0, 1]"));
  put("frame_00000.jpg",
      std::string("\xFF\xD8\xFF\xE0\x00\x04\x00\x00\xFF\xC0\x00\x11\x08\x02\xD0\x03\xC0\x03", 18));
  EXPECT_NEAR(open().camera()->camera.intrinsics.fx, 800 * 8 / 960.0, 1e-9);
}

TEST_F(Rules, ImagesWhoseJsonIsTornAreLeftOutAndNamed) {
  put("camera.ini", kCamera);
  for (int i = 0; i < 4; ++i) {
    putDepth("depth_0000" + std::to_string(i) + ".png");
    put("frame_0000" + std::to_string(i) + ".json", i == 0 ? "{\"time\": 1" : frameJson(i));
  }
  const DepthSequence sequence = open();
  EXPECT_THAT(stampsOf(sequence), ElementsAre(101.25, 102.25, 103.25));
  EXPECT_THAT(sequence.remark(), HasAll("1 without a time", "frame_00000.json: is no JSON"));
}

TEST_F(Rules, TransformsOfNeRFsHaveTimesPosesAndTheCamera) {
  putDepth("depth/frame_00001.png"), putDepth("depth/frame_00002.png");
  const std::string head =
      "{\"fl_x\": 16, \"fl_y\": 16, \"cx\": 8, \"cy\": 6, \"w\": 16, \"h\": 12, \"frames\": [";
  const std::string matrix = "\"transform_matrix\": [[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]]";
  const std::string second = "{" + matrix + ", \"file_path\": \"./images/frame_00002.jpg\"";
  const std::string first = "{\"file_path\": \"images/frame_00001.jpg\", " + matrix;
  put("transforms.json", head + second + ", \"timestamp\": 20.5}, " + first + ", \"timestamp\": 20.25}]}");
  const DepthSequence stamped = open();
  EXPECT_THAT(stampsOf(stamped), ElementsAre(20.25, 20.5));
  EXPECT_EQ(stamped.camera()->camera.intrinsics.fx, 8);
  EXPECT_EQ(stamped.groundTruth().at(20.5)->translation(), Eigen::Vector3d(5, 6, 7));
  EXPECT_TRUE(stamped.groundTruth().at(20.5)->linear().isApprox(
      Eigen::Matrix3d(Eigen::Vector3d(1, -1, -1).asDiagonal()), 1e-9));
  put("transforms.json", head + second + "}, " + first + "}]}");
  const DepthSequence counted = open();
  ASSERT_EQ(counted.groundTruth().poses().size(), 2u);
  EXPECT_EQ(counted.groundTruth().poses()[0].stamp, counted.frames()[0].stamp);
  EXPECT_THAT(counted.remark(), HasAll("poses of the images are those of transforms.json", "only numbered"));
}

TEST_F(Rules, ACalibrationOfOtherImagesIsIgnored) {
  putDepth("depth/1.5.png");
  put("camera.json", "{\"fx\": 1600, \"fy\": 1600, \"cx\": 960, \"cy\": 720}");
  EXPECT_THAT(errorOf(), HasSubstr("camera.ini"));
}

TEST_F(Rules, WithoutAMatchTheMessageListsTheContent) {
  for (int i = 0; i < 3; ++i) put("rgb/" + std::to_string(i) + ".jpg", "x");
  put("notes.md", "x");
  EXPECT_THAT(errorOf(), HasAll("no depth images", "rgb/ (3 .jpg)", "1 .md"));
  put("home/home.db", "x");
  EXPECT_THAT(errorOf("home"), HasSubstr("named itself"));
  put("exr/0.exr", "x");
  EXPECT_THAT(errorOf(), HasAll("OpenEXR is not read", "oiiotool"));
  put("walk.db", "x");
  EXPECT_THAT(errorOf("walk.db"), HasSubstr("rtabmap-export"));
  EXPECT_THAT(errorOf("rgb/0.jpg"), HasAll("is no recording", Not(HasSubstr("; ;"))));
}

}  // namespace
}  // namespace facetloc::test
