// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/features/pose.h>
#include <facetloc/io/trajectory.h>

#include <cmath>
#include <stdexcept>

namespace facetloc::test {
namespace {

const Eigen::Vector3d kUpright = Eigen::Vector3d::Zero();

StampedPose poseAt(double stamp, const Eigen::Vector3d& phi = {0.1, -0.2, 0.3},
                   const Eigen::Vector3d& t = {1, 2, 3}) {
  StampedPose pose;
  pose.stamp = stamp;
  pose.T_w_c.linear() = expSO3(phi);
  pose.T_w_c.translation() = t;
  return pose;
}

std::string errorOf(const std::string& content) {
  const TemporaryFolder folder;
  putBytes(folder / "groundtruth.txt", content);
  return ioErrorOf([&] { readTumTrajectory(folder / "groundtruth.txt"); });
}

TEST(Trajectory, BetweenTwoPosesTheMotionIsEven) {
  const Trajectory poses({poseAt(2, {0, 0, 0.8}, {3, 0, 0}), poseAt(1, {0, 0, 0.4}, {1, 0, 2})});
  const auto middle = poses.interpolated(1.25);
  ASSERT_TRUE(middle);
  EXPECT_LT((middle->linear() - expSO3({0, 0, 0.5})).norm(), 1e-12);
  EXPECT_LT((middle->translation() - Eigen::Vector3d(1.5, 0, 1.5)).norm(), 1e-12);
  EXPECT_EQ(poses.interpolated(1)->matrix(), poses.poses()[0].T_w_c.matrix());
  EXPECT_EQ(poses.interpolated(2)->matrix(), poses.poses()[1].T_w_c.matrix());
  EXPECT_FALSE(poses.interpolated(0.999));
  EXPECT_FALSE(poses.interpolated(2.001));
  EXPECT_FALSE(Trajectory().interpolated(1));
  const Trajectory twice({poseAt(1), poseAt(1, kUpright), poseAt(2)});  // two poses of one stamp
  EXPECT_TRUE(twice.interpolated(1.5)->matrix().allFinite());
}

TEST(Trajectory, RoundTrips) {
  const TemporaryFolder folder;
  const std::vector<StampedPose> poses = {poseAt(1305031102.175304, {3.1, 0.1, -0.2}, {1.0 / 3, -1e-7, 1e5}),
                                          poseAt(1305031102.275304)};
  writeTumTrajectory(folder / "poses.txt", poses);
  const Trajectory read = readTumTrajectory(folder / "poses.txt");
  ASSERT_EQ(read.poses().size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(read.poses()[i].stamp, poses[i].stamp, 1e-6);
    EXPECT_LT(boxminus(read.poses()[i].T_w_c, poses[i].T_w_c).head<3>().norm(), 1e-8);
    EXPECT_TRUE(read.poses()[i].T_w_c.translation().isApprox(poses[i].T_w_c.translation(), 1e-8));
  }
}

TEST(Trajectory, WritesExactlyEightColumns) {
  const TemporaryFolder folder;
  StampedPose identity = poseAt(0.5, kUpright, {-0.0, 1, 2});
  writeTumTrajectory(folder / "poses.txt", {identity});
  EXPECT_EQ(bytesOf(folder / "poses.txt"), "# timestamp tx ty tz qx qy qz qw\n0.500000 0 1 2 0 0 0 1\n");
}

TEST(Trajectory, RefusesToWriteNonFiniteNumbers) {
  const TemporaryFolder folder;
  EXPECT_THROW(writeTumTrajectory(folder / "poses.txt", {poseAt(NAN)}), std::invalid_argument);
  EXPECT_EQ(folder.count(), 0);
}

TEST(Trajectory, TheNearestPoseWithinTheToleranceCountsInAGap) {
  const Trajectory trajectory(
      {poseAt(2, kUpright, {2, 0, 0}), poseAt(1, kUpright, {1, 0, 0}), poseAt(1.1, kUpright, {1.1, 0, 0})});
  constexpr double kShort = 0.019;  // five of these are less than the gap of 0.1 s
  EXPECT_EQ(trajectory.at(1.01, kShort)->translation().x(), 1);
  EXPECT_EQ(trajectory.at(1.09, kShort)->translation().x(), 1.1);
  EXPECT_EQ(trajectory.at(1.019, kShort)->translation().x(), 1) << "the tolerance is meant in decimals";
  EXPECT_EQ(trajectory.at(0.99)->translation().x(), 1);
  EXPECT_EQ(trajectory.at(2.015)->translation().x(), 2);
  EXPECT_FALSE(trajectory.at(1.05, kShort));
  EXPECT_FALSE(trajectory.at(0.9));
  EXPECT_FALSE(trajectory.at(2.1));
  EXPECT_FALSE(trajectory.at(NAN));
  EXPECT_EQ(trajectory.at(1.25, 0.17)->translation().x(), 1.1) << "five times 0.17 are less than the gap";
  EXPECT_NEAR(trajectory.at(1.5, 1)->translation().x(), 1.5, 1e-9);
  EXPECT_FALSE(Trajectory().at(0));
}

TEST(Trajectory, BetweenPosesThatAreCloseInTimeTheyAreInterpolated) {
  const Trajectory trajectory({poseAt(1, kUpright, {1, 0, 0}), poseAt(1.1, kUpright, {1.1, 0, 0})});
  for (const double stamp : {1.0, 1.01, 1.05, 1.09, 1.1})
    EXPECT_NEAR(trajectory.at(stamp)->translation().x(), stamp, 1e-9);
  EXPECT_EQ(trajectory.at(0.985)->translation().x(), 1) << "before the first pose, which is near";
  EXPECT_FALSE(trajectory.at(1.13));
}

TEST(Trajectory, ReadsCommentsAndUnorderedLines) {
  const TemporaryFolder folder;
  putBytes(folder / "g.txt", "# header\n\n 2 0 0 0 0 0 0 1 # later\r\n+1e0\t0 0 0 0 0 0 -1\n");
  const Trajectory trajectory = readTumTrajectory(folder / "g.txt");
  ASSERT_EQ(trajectory.poses().size(), 2u);
  EXPECT_EQ(trajectory.poses()[0].stamp, 1);
  EXPECT_TRUE(trajectory.poses()[0].T_w_c.isApprox(Eigen::Isometry3d::Identity()));
}

TEST(Trajectory, AnEmptyFileIsAnEmptyTrajectory) {
  EXPECT_EQ(errorOf(""), "");
  EXPECT_EQ(errorOf("# nothing yet\n"), "");
}

TEST(Trajectory, NamesTheLineOfAFault) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  EXPECT_THAT(errorOf(good + "2 0 0 0 0 0 0\n"), HasAll("groundtruth.txt", "line 2", "7 columns"));
  EXPECT_THAT(errorOf(good + "2 0 0 0 0 0 0 1 9\n"), HasSubstr("9 columns"));
  EXPECT_THAT(errorOf(good + "2 0 0 zero 0 0 0 1\n"), HasSubstr("'zero'"));
  EXPECT_THAT(errorOf(good + "2 0 0 nan 0 0 0 1\n"), HasSubstr("'nan'"));
  EXPECT_THAT(errorOf(good + "\n2 0 0 0 0 0 0 0\n"), HasAll("line 3", "rotation"));
  EXPECT_THAT(errorOf(good + "2 0 0 0 1 0 0 1\n"), HasSubstr("rotation"));
  EXPECT_THAT(errorOf(good + "2 0 0 2e6 0 0 0 1\n"), HasSubstr("its pose is more than 1000 km away"));
  EXPECT_THAT(errorOf(good + "1e12 0 0 0 0 0 0 1\n"), HasSubstr("its stamp is impossible"));
  EXPECT_THAT(errorOf(std::string("\0\x89PNG\xFF", 6)), HasSubstr("line 1"));
  EXPECT_THAT(ioErrorOf([] { readTumTrajectory("no/such/file.txt"); }), HasSubstr("does not exist"));
}

}  // namespace
}  // namespace facetloc::test
