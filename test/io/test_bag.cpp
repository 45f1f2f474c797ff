// SPDX-License-Identifier: BSD-3-Clause
// Bags as ROS's own library writes them.

#include "example_sequence.h"
#include "temporary_folder.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/testing/example_bag.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using test::bytesOf;
using test::ExampleSequence;
using test::ioErrorOf;
using test::putBytes;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

Trajectory odometry() { return Trajectory(test::turningPath(5)); }

class Bag : public testing::Test {
protected:
  void SetUp() override {
    if (!test::hasBags()) GTEST_SKIP() << "no python3-rosbag to write bags with, or a build that reads none";
    example_.frames = 6;
    sequence_.emplace(DepthSequence::open(example_.write(folder_ / "sequence")));
  }
  fs::path bag(const std::string& kind) const {
    const fs::path path = folder_ / (kind + ".bag");
    EXPECT_TRUE(test::writeBag(*sequence_, path, kind, odometry())) << kind;
    return path;
  }

  TemporaryFolder folder_;
  ExampleSequence example_;
  std::optional<DepthSequence> sequence_;
};

TEST_F(Bag, HasTheImagesOfTheTopicCalledDepthAtTheTimesTheyWereTaken) {
  for (const char* kind : {"uint16", "float", "compressed", "compressed_depth", "realsense"}) {
    const DepthSequence read = DepthSequence::open(bag(kind));
    ASSERT_EQ(read.frames().size(), 6u) << kind;
    EXPECT_TRUE(read.stamped());
    EXPECT_THAT(read.remark(),
                HasSubstr(std::string(kind) == "realsense" ? "Depth_0" : "/camera/depth/image_raw"));
    for (int i = 0; i < 6; ++i) {
      EXPECT_EQ(read.frames()[i].name, example_.name(i)) << kind;
      const DepthImage image = read.load(i), expected = example_.image(i);
      EXPECT_EQ(image.camera, expected.camera);
      ASSERT_EQ(image.depth.size(), expected.depth.size());
      for (std::size_t p = 0; p < image.depth.size(); ++p)
        ASSERT_NEAR(image.depth[p], expected.depth[p], 1e-5f) << kind << ", pixel " << p;
    }
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
  const DepthSequence read = DepthSequence::open(bag("compressed"));
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int n = 0; n < 30; ++n) {
        const int i = (7 * n + t) % 6;
        wrong += read.load(i).depth[1] != example_.image(i).depth[1];
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST_F(Bag, OdometryIsOfMessagesOrTf) {
  const Trajectory written = odometry();
  for (const char* kind : {"uint16", "compressed"}) {
    const fs::path path = bag(kind);
    const Trajectory read = DepthSequence::open(path).readPoses(path);
    ASSERT_EQ(read.poses().size(), 5u) << kind;
    for (const StampedPose& pose : written.poses())
      EXPECT_TRUE(read.at(pose.stamp, 1e-5)->isApprox(pose.T_w_c, 1e-6)) << kind;
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
  EXPECT_THAT(fisheye.remark(), AllOf(HasSubstr("equidistant"), HasSubstr("left in")));
}

TEST_F(Bag, ATopicCanBeNamed) {
  RecordingHints hints;
  hints.topic = "/camera/depth/image_raw";
  const fs::path path = bag("uint16");
  EXPECT_EQ(DepthSequence::open(path, hints).frames().size(), 6u);
  hints.topic = "/camera/color/image_raw";
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(path, hints); }),
              AllOf(HasSubstr("/camera/color/image_raw"), HasSubstr("/camera/depth/image_raw (6)")));
}

TEST_F(Bag, UnreadableFilesAreAnErrorWithTheCause) {
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(bag("colour")); }),
              AllOf(HasSubstr("no depth images"), HasSubstr("/camera/color/image_raw")));
  for (const char* kind : {"big_endian", "short"}) {
    const DepthSequence read = DepthSequence::open(bag(kind));
    EXPECT_THAT(ioErrorOf([&] { read.load(0); }), HasSubstr("image 0")) << kind;
  }
  const std::string bytes = bytesOf(bag("uint16"));
  for (const std::string& broken : {std::string(), std::string("no bag"), bytes.substr(0, bytes.size() / 2),
                                    bytes.substr(0, 13), std::string(5000, '\xff')}) {
    putBytes(folder_ / "broken.bag", broken);
    EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder_ / "broken.bag"); }), HasSubstr("broken.bag"));
  }
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(folder_ / "none.bag"); }), HasSubstr("does not exist"));
}

TEST_F(Bag, WithoutOdometryIsAnError) {
  const fs::path path = folder_ / "still.bag";
  ASSERT_TRUE(test::writeBag(*sequence_, path, "uint16"));
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(path).readPoses(path); }), HasSubstr("no odometry"));
}

}  // namespace
}  // namespace facetloc
