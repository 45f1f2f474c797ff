// SPDX-License-Identifier: BSD-3-Clause
// Databases of RTAB-Map, as Python writes them.

#include "changed_database.h"
#include "recorded_sequence.h"

namespace facetloc::test {
namespace {

class RtabmapDatabases : public RecordedSequence {
protected:
  void SetUp() override {
    if (!hasRecordings()) GTEST_SKIP() << "no Python to write recordings with";
    writeSequence();
  }
  fs::path database(const std::string& words) const {
    return recordAs("home", ".db", "rtabmap " + words, Trajectory(poses()));
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
};

TEST_F(RtabmapDatabases, HaveTheirImagesAndThePosesOfTheGraph) {
  for (const char* words : {"png", "32FC1", "rvl"}) {
    const DepthSequence read = DepthSequence::open(database(words));
    EXPECT_THAT(read.remark(), HasSubstr("5 of its 6 images have poses, of its optimised graph"));
    expectPoses(read.groundTruth(), poses(), 1e-5, words);
    expectImages(read, 0, words);
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
  // Twice the size, in the header.
  sql(file, "UPDATE Data SET calibration = CAST(substr(calibration, 1, 16) || x'8000000060000000' || "
            "substr(calibration, 25) AS BLOB) WHERE calibration IS NOT NULL");
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
              HasAll("node 1", "PNG"));
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
}  // namespace facetloc::test
