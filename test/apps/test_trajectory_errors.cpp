// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/trajectory_errors.h"

#include <facetloc/features/pose.h>
#include <facetloc/testing/matchers.h>

#include <cmath>
#include <stdexcept>

namespace facetloc::test {
namespace {

constexpr double kStep = 0.1, kInterval = 0.2;  // [m], [s]: half a metre per second

Eigen::Isometry3d pose(double x, double y, double z, double yaw) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = expSO3({0, 0, yaw});
  T.translation() << x, y, z;
  return T;
}

/** Along a line, turned by so much in every step, and each step so much too long. */
Trajectory straight(int steps, double turn = 0, double scale = 1) {
  std::vector<StampedPose> poses = {{0, Eigen::Isometry3d::Identity()}};
  for (int i = 1; i <= steps; ++i)
    poses.push_back({i * kInterval, poses.back().T_w_c * pose(scale * kStep, 0, 0, turn)});
  return Trajectory(poses);
}

const RelativeErrors& over(const TrajectoryErrors& errors, const std::string& what) {
  for (const RelativeErrors& r : errors.relative)
    if (r.over == what) return r;
  throw std::out_of_range(what);
}

TEST(Sample, HasMoments) {
  const Sample m({3, 0, 4, 1});
  EXPECT_DOUBLE_EQ(m.rmse, std::sqrt(26 / 4.));
  EXPECT_DOUBLE_EQ(m.mean, 2);
  EXPECT_DOUBLE_EQ(m.median, 2);
  EXPECT_DOUBLE_EQ(m.max, 4);
  EXPECT_DOUBLE_EQ(Sample({3, 0, 4}).median, 3);
  EXPECT_EQ(Sample().rmse, 0);
}

TEST(TrajectoryErrors, AreZeroInAnotherFrame) {
  const Trajectory truth = straight(60, 0.05);
  const Eigen::Isometry3d motion = pose(4, -2, 1, 2.5);
  std::vector<StampedPose> moved = truth.poses();
  for (StampedPose& p : moved) p.T_w_c = motion * p.T_w_c;
  const TrajectoryErrors e = trajectoryErrors(Trajectory(moved), truth);
  EXPECT_TRUE(e.alignment.T_true_estimated.isApprox(motion.inverse(), 1e-9));
  EXPECT_NEAR(e.absolute.max, 0, 1e-9);
  EXPECT_NEAR(e.absolute_rotation_deg.max, 0, 1e-6);
  EXPECT_NEAR(e.length(), 60 * kStep, 1e-9);
  EXPECT_NEAR(e.duration(), 60 * kInterval, 1e-9);
  ASSERT_EQ(e.relative.size(), 3u);
  for (const RelativeErrors& r : e.relative) EXPECT_NEAR(r.translation.max, 0, 1e-9) << r.over;
}

TEST(TrajectoryErrors, AWrongScaleIsAShareOfTheDistance) {
  // 2 % too long: after alignment of the middles the error grows from there to both ends.
  const int steps = 100;
  const double distance = steps * kStep;
  const TrajectoryErrors e = trajectoryErrors(straight(steps, 0, 1.02), straight(steps));
  EXPECT_NEAR(e.absolute.max, 0.02 * distance / 2, 1e-9);
  const double n = steps + 1;  // equally spaced: variance (n^2 - 1) / 12
  EXPECT_NEAR(e.absolute.rmse, 0.02 * kStep * std::sqrt((n * n - 1) / 12), 1e-9);
  EXPECT_NEAR(e.share(), e.absolute.rmse / distance, 1e-12);
  EXPECT_NEAR(e.absolute_rotation_deg.max, 0, 1e-6);
  for (const std::string what : {"1 s", "1 m", "10 % of the way"}) {
    EXPECT_NEAR(over(e, what).translationShare(), 0.02, 1e-9) << what;
    EXPECT_NEAR(over(e, what).rotationPerMetre(), 0, 1e-6) << what;
  }
  EXPECT_NEAR(over(e, "1 s").translation.rmse, 0.02 * 0.5, 1e-9);
  EXPECT_EQ(over(e, "1 s").intervals, 101u - 5);
  EXPECT_NEAR(over(e, "1 m").translation.median, 0.02, 1e-9);
  EXPECT_EQ(over(e, "1 m").intervals, 101u - 10);
}

TEST(TrajectoryErrors, ASteadyTurnIsAConstantRotationPerMetre) {
  const double turn = 0.1 * kDegree;  // per step of 0.1 m
  const TrajectoryErrors e = trajectoryErrors(straight(50, turn), straight(50));
  EXPECT_NEAR(over(e, "1 m").rotationPerMetre(), 1, 1e-6);
  EXPECT_NEAR(over(e, "1 s").rotation_deg.rmse, 0.5, 1e-6);
  EXPECT_NEAR(over(e, "10 % of the way").rotation_deg.max, 0.5, 1e-6);
  // The k-th of the ten steps is turned by (k - 1) times as much.
  Eigen::Vector2d end(0, 0);
  for (int k = 0; k < 10; ++k) end += kStep * Eigen::Vector2d(std::cos(k * turn), std::sin(k * turn));
  EXPECT_NEAR(over(e, "1 m").translation.mean, (end - Eigen::Vector2d(1, 0)).norm(), 1e-9);
}

TEST(TrajectoryErrors, AnOutlierIsInTheMaximum) {
  std::vector<StampedPose> poses = straight(200, 0.03).poses();
  poses[100].T_w_c.translation().z() += 0.5;
  const TrajectoryErrors e = trajectoryErrors(Trajectory(poses), straight(200, 0.03));
  EXPECT_NEAR(e.absolute.max, 0.5, 0.02);
  EXPECT_LT(e.absolute.median, 0.01);
  EXPECT_NEAR(e.absolute.rmse, 0.5 / std::sqrt(201.), 0.002);
}

TEST(TrajectoryErrors, PosesWithoutATrueOneAreCounted) {
  std::vector<StampedPose> truth = straight(30, 0.05).poses();
  truth.erase(truth.begin() + 10, truth.begin() + 20);
  for (StampedPose& p : truth) p.stamp += 0.015;
  const TrajectoryErrors e = trajectoryErrors(straight(30, 0.05), Trajectory(truth));
  EXPECT_EQ(e.pairs.size(), 21u);
  EXPECT_EQ(e.without_truth, 10u);
  EXPECT_THROW(trajectoryErrors(straight(30), Trajectory(truth), 0.01), std::invalid_argument);
}

TEST(TrajectoryErrors, NoIntervalBridgesAGap) {
  std::vector<StampedPose> truth = straight(60, 0.05).poses();
  truth.erase(truth.begin() + 20, truth.begin() + 40);  // 2.1 m and 4.2 s between their neighbours
  const TrajectoryErrors e = trajectoryErrors(straight(60, 0.05), Trajectory(truth));
  EXPECT_EQ(over(e, "1 s").intervals, 15u + 16) << "of 20 and of 21 poses";
}

TEST(TrajectoryErrors, ACameraThatStandsHasNoDistance) {
  std::vector<StampedPose> poses;
  for (int i = 0; i < 20; ++i) poses.push_back({i * 0.1, pose(1, 2, 3, 0.5)});
  const TrajectoryErrors e = trajectoryErrors(Trajectory(poses), Trajectory(poses));
  ASSERT_EQ(e.relative.size(), 1u);
  EXPECT_EQ(e.relative[0].over, "1 s");
  EXPECT_EQ(e.relative[0].translationShare(), 0);
  EXPECT_EQ(e.share(), 0);
  EXPECT_NEAR(e.absolute.max, 0, 1e-9);
}

std::string complaint(const Trajectory& estimate, const Trajectory& truth) {
  return messageOf<std::invalid_argument>([&] { trajectoryErrors(estimate, truth); });
}

TEST(TrajectoryErrors, NameTheFault) {
  std::vector<StampedPose> later = straight(10).poses(), twice = later;
  for (StampedPose& p : later) p.stamp += 1000;
  twice[4].stamp = twice[5].stamp;
  EXPECT_THAT(complaint(straight(10), Trajectory(later)), HasSubstr("0 pairs"));
  EXPECT_THAT(complaint(straight(1), straight(10)), HasSubstr("2 pairs"));
  EXPECT_THAT(complaint(Trajectory(), straight(10)), HasSubstr("0 pairs"));
  EXPECT_THAT(complaint(straight(10), Trajectory(twice)), HasSubstr("two true poses have the stamp 1"));
  EXPECT_THAT(complaint(Trajectory(twice), straight(10)), HasSubstr("two estimated poses"));
  EXPECT_EQ(complaint(straight(2), straight(10)), "");
}

}  // namespace
}  // namespace facetloc::test
