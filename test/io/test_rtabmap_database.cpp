// SPDX-License-Identifier: BSD-3-Clause
// Databases of RTAB-Map, as Python writes them.

#include "changed_database.h"
#include "example_sequence.h"
#include "temporary_folder.h"

#include <facetloc/testing/example_bag.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using test::ExampleSequence;
using test::ioErrorOf;
using test::putBytes;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

class RtabmapDatabases : public testing::Test {
protected:
  void SetUp() override {
    if (!test::hasRecordings()) GTEST_SKIP() << "no Python to write recordings with";
    example_.frames = 6;
    sequence_.emplace(DepthSequence::open(example_.write(folder_ / "sequence")));
  }
  fs::path database(const std::string& words) const {
    const fs::path path = folder_ / ("home" + std::to_string(++count_) + ".db");
    EXPECT_TRUE(test::writeRecording(*sequence_, path, "rtabmap " + words, Trajectory(poses()))) << words;
    return path;
  }
  /** Poses of the camera, for all images but the last. */
  std::vector<StampedPose> poses() const {
    std::vector<StampedPose> poses;
    for (int i = 0; i < 5; ++i) {
      StampedPose pose;
      pose.stamp = example_.stamp(i);
      pose.T_w_c.translation() << i, 2, 0.5 * i;
      pose.T_w_c.linear() =
          Eigen::AngleAxisd(0.2 * i, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
      poses.push_back(pose);
    }
    return poses;
  }
  std::string errorWhenChanged(const char* sql) const { return test::errorWhenChanged(database(""), sql); }

  TemporaryFolder folder_;
  ExampleSequence example_;
  std::optional<DepthSequence> sequence_;
  mutable int count_ = 0;
};

TEST_F(RtabmapDatabases, HaveTheirImagesAndThePosesOfTheGraph) {
  for (const char* words : {"png", "32FC1", "rvl"}) {
    const DepthSequence read = DepthSequence::open(database(words));
    ASSERT_EQ(read.frames().size(), 6u) << words;
    EXPECT_THAT(read.remark(), HasSubstr("5 of its 6 images have poses, of its optimised graph"));
    ASSERT_EQ(read.groundTruth().poses().size(), 5u);
    for (const StampedPose& pose : poses())
      EXPECT_TRUE(read.groundTruth().at(pose.stamp, 1e-5)->isApprox(pose.T_w_c, 1e-5)) << words;
    for (int i = 0; i < 6; ++i) {
      EXPECT_EQ(read.frames()[i].name, example_.name(i));
      EXPECT_EQ(read.load(i).camera, example_.camera);
      EXPECT_EQ(read.load(i).depth, example_.image(i).depth) << words;
    }
  }
}

TEST_F(RtabmapDatabases, WithoutAGraphThePosesAreItsOdometry) {
  const fs::path file = database("no_graph");
  const DepthSequence read = DepthSequence::open(file);
  EXPECT_THAT(read.remark(), HasSubstr("odometry, since no graph was saved"));
  const Eigen::Vector3d drift(0.03, 0, 0);  // as it is written, of the third
  EXPECT_TRUE(read.groundTruth()
                  .at(example_.stamp(2), 1e-5)
                  ->translation()
                  .isApprox(poses()[2].T_w_c.translation() + drift, 1e-5));
  EXPECT_EQ(DepthSequence::readTruth(file).poses().size(), 5u);
  EXPECT_EQ(sequence_->readPoses(file).poses().size(), 5u) << "as poses of another recording";
}

TEST_F(RtabmapDatabases, OfColourWithMorePixelsHaveTheCameraOfTheirDepth) {
  const fs::path file = database("");
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &db), SQLITE_OK);
  // Twice the size, in the header.
  ASSERT_EQ(
      sqlite3_exec(db,
                   "UPDATE Data SET calibration = CAST(substr(calibration, 1, 16) || x'8000000060000000' || "
                   "substr(calibration, 25) AS BLOB) WHERE calibration IS NOT NULL",
                   nullptr, nullptr, nullptr),
      SQLITE_OK);
  sqlite3_close(db);
  const Intrinsics camera = DepthSequence::open(file).load(0).camera;
  EXPECT_EQ(camera.width, example_.camera.width);
  EXPECT_DOUBLE_EQ(camera.fx, example_.camera.fx / 2);
  EXPECT_DOUBLE_EQ(camera.cy, example_.camera.cy / 2);
}

TEST_F(RtabmapDatabases, UnreadableFilesAreAnErrorWithTheCause) {
  EXPECT_EQ(errorWhenChanged("SELECT 1"), "");
  EXPECT_THAT(errorWhenChanged("DROP TABLE Node"), HasSubstr("is no database of RTAB-Map"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET depth = NULL"), HasSubstr("no depth images"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET depth = x'ffd8ffe0' WHERE depth IS NOT NULL"),
              AllOf(HasSubstr("node 1"), HasSubstr("PNG")));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET depth = 'text' WHERE depth IS NOT NULL"),
              HasSubstr("not a blob"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET calibration = NULL"), HasSubstr("its calibration"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET calibration = calibration || calibration"),
              HasSubstr("not a blob"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET calibration = CAST(calibration || calibration AS BLOB)"),
              HasSubstr("several cameras"));
  EXPECT_THAT(errorWhenChanged("UPDATE Data SET calibration = CAST(substr(calibration, 1, 12) || x'01' || "
                               "substr(calibration, 14) AS BLOB)"),
              HasSubstr("stereo"));
  EXPECT_THAT(
      errorWhenChanged("UPDATE Data SET calibration = CAST(substr(calibration, 1, 28) || x'ffffff7f' || "
                       "substr(calibration, 33) AS BLOB)"),
      HasSubstr("its calibration"));
  EXPECT_THAT(errorWhenChanged("UPDATE Admin SET opt_poses = x'0102030405060708090a0b0c0d0e0f'"),
              HasSubstr("corrupt graph"));
  EXPECT_THAT(errorWhenChanged("UPDATE Node SET stamp = 1e300"), HasSubstr("impossible time"));
  for (const std::string& broken : {std::string(), std::string("nothing"), std::string(5000, '\xff')}) {
    const fs::path file = putBytes(folder_ / "broken.db", broken);
    EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(file); }), HasSubstr("broken.db"));
  }
}

}  // namespace
}  // namespace facetloc
