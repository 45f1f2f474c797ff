// SPDX-License-Identifier: BSD-3-Clause
// Bags as ROS's own library writes them.

#include "recorded_sequence.h"

namespace facetloc::test {
namespace {

Trajectory odometry() { return Trajectory(turningPath(5)); }

class Bag : public RecordedSequence {
protected:
  void SetUp() override {
    if (!hasBags()) GTEST_SKIP() << "no python3-rosbag to write bags with";
    writeSequence();
  }
  fs::path bag(const std::string& kind) const {
    const fs::path path = folder_ / (kind + ".bag");
    EXPECT_TRUE(writeBag(*sequence_, path, kind, odometry())) << kind;
    return path;
  }
};

TEST_F(Bag, HasTheImagesOfTheTopicCalledDepthAtTheTimesTheyWereTaken) {
  for (const char* kind : {"uint16", "float", "compressed", "compressed_depth", "realsense"}) {
    const DepthSequence read = DepthSequence::open(bag(kind));
    EXPECT_THAT(read.remark(),
                HasSubstr(std::string(kind) == "realsense" ? "Depth_0" : "/camera/depth/image_raw"));
    expectImages(read, 1e-5f, kind);
  }
}

TEST_F(Bag, OfRealSenseHasItsNoiseAndUnit) {
  const CameraFile camera = *DepthSequence::open(bag("realsense")).camera();
  EXPECT_EQ(camera.preset, "realsense_d435");
  EXPECT_EQ(camera.camera.max_depth, 6);
  EXPECT_NEAR(camera.depth_scale, 2000, 0.1);
}

TEST_F(Bag, GravityIsByItsImu) {
  std::string remark;
  const GravityRecord gravity = DepthSequence::open(bag("imu")).gravity(0.01, &remark);
  EXPECT_THAT(remark, HasSubstr("/imu"));
  ASSERT_EQ(gravity.samples().size(), 6u);
  EXPECT_LT((gravity.samples()[2].gravity.down - Eigen::Vector3d::UnitY()).norm(), 1e-9);
}

TEST_F(Bag, IsReadByManyThreads) {
  expectToBeReadByManyThreads(DepthSequence::open(bag("compressed")), 1e-5f);
}

TEST_F(Bag, OdometryIsOfMessagesOrTf) {
  for (const char* kind : {"uint16", "compressed"}) {
    const fs::path path = bag(kind);
    expectPoses(DepthSequence::open(path).readPoses(path), odometry().poses(), 1e-6, kind);
  }
}

TEST_F(Bag, ACameraFileNextToItCounts) {
  const fs::path path = bag("no_camera");
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(path); }), HasSubstr("camera.ini"));
  writeTumTrajectory(folder_ / "groundtruth.txt", odometry().poses());
  EXPECT_EQ(DepthSequence::readTruth(path).poses().size(), 5u) << "poses need no camera";
  CameraFile file;
  file.camera.intrinsics = example_.camera;
  file.camera.intrinsics.fx = 77;
  writeCameraFile(folder_ / "camera.ini", file);
  EXPECT_EQ(DepthSequence::open(path).load(0).camera.fx, 77);
}

TEST_F(Bag, TheLensOfItsCameraIsTakenOut) {
  const DepthSequence bent = DepthSequence::open(bag("lens"));
  EXPECT_EQ(bent.camera()->lens.k1, 0.1);
  EXPECT_EQ(bent.camera()->lens.p2, 0.002);
  EXPECT_THAT(bent.remark(), HasSubstr("the lens of its camera_info is taken out"));
  const LensCorrection lens(bent.camera()->camera.intrinsics, bent.camera()->lens);
  EXPECT_EQ(bent.load(0).depth, lens(DepthSequence::open(bag("uint16")).load(0)).depth);
  const DepthSequence fisheye = DepthSequence::open(bag("fisheye"));
  EXPECT_TRUE(fisheye.camera()->isPinhole());
  EXPECT_THAT(fisheye.remark(), HasAll("equidistant", "left in"));
}

TEST_F(Bag, ATopicCanBeNamed) {
  RecordingHints hints;
  hints.topic = "/camera/depth/image_raw";
  const fs::path path = bag("uint16");
  EXPECT_EQ(DepthSequence::open(path, hints).frames().size(), 6u);
  hints.topic = "/camera/color/image_raw";
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(path, hints); }),
              HasAll("/camera/color/image_raw", "/camera/depth/image_raw (6)"));
}

TEST_F(Bag, UnreadableFilesAreAnErrorWithTheCause) {
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(bag("colour")); }),
              HasAll("no depth images", "/camera/color/image_raw"));
  const DepthSequence read = DepthSequence::open(bag("short"));
  EXPECT_THAT(ioErrorOf([&] { read.load(0); }), HasSubstr("image 0"));
  const std::string bytes = bytesOf(bag("uint16"));
  for (const std::string& broken : {std::string(), std::string("no bag"), bytes.substr(0, bytes.size() / 2),
                                    bytes.substr(0, 13), std::string(5000, '\xff')}) {
    putBytes(folder_ / "broken.bag", broken);
    EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder_ / "broken.bag"); }), HasSubstr("broken.bag"));
  }
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder_ / "none.bag"); }), HasSubstr("does not exist"));
}

TEST_F(Bag, IsReadByItsRecordsAndNotItsIndex) {
  for (const char* compression : {"uint16", "compressed"}) {
    std::string bytes = bytesOf(bag(compression));
    const std::size_t index = bytes.find(std::string("op=\4"));
    ASSERT_NE(index, std::string::npos);
    constexpr std::size_t kOffset = 22;  // bytes to the place of the first message
    bytes.replace(bytes.find("count=", index) + kOffset, 4, "\xff\xff\xff\x7f");
    putBytes(folder_ / "index.bag", bytes);
    EXPECT_EQ(DepthSequence::open(folder_ / "index.bag").frames().size(), 6u) << compression;
  }
}

TEST_F(Bag, ATornOneIsReadAsFarAsItGoes) {
  CameraFile file;
  file.camera.intrinsics = example_.camera;
  writeCameraFile(folder_ / "camera.ini", file);
  const std::string bytes = bytesOf(bag("uint16"));
  const std::size_t chunk = bytes.find(std::string("op=\5")), index = bytes.find(std::string("op=\4"));
  putBytes(folder_ / "torn.bag", bytes.substr(0, chunk + (index - chunk) / 2));
  const DepthSequence read = DepthSequence::open(folder_ / "torn.bag");
  EXPECT_THAT(read.frames().size(), testing::AllOf(testing::Ge(1u), testing::Lt(6u)));
  EXPECT_THAT(read.remark(), HasSubstr("never finished"));
}

TEST_F(Bag, AnyDamageIsReadOrRefused) {
  const std::string bytes = bytesOf(bag("uint16"));
  constexpr std::size_t kBegin = 4100, kRecords = 600;  // bytes in front of the chunk, and of records
  for (std::size_t k = 0; k < 2 * kRecords; ++k) {
    const std::size_t i = k < kRecords ? kBegin + k : bytes.size() - 2 * kRecords + k;
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(~damaged[i]);
    putBytes(folder_ / "damaged.bag", damaged);
    try {
      DepthSequence::open(folder_ / "damaged.bag");
    } catch (const IoError&) {
    }
  }
}

TEST_F(Bag, WithoutOdometryIsAnError) {
  const fs::path path = folder_ / "still.bag";
  ASSERT_TRUE(writeBag(*sequence_, path, "uint16"));
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(path).readPoses(path); }), HasSubstr("no odometry"));
}

}  // namespace
}  // namespace facetloc::test
