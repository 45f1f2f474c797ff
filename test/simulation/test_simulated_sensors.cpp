// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_sensors.h>

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr int kRuns = 4000;

double headingOf(const Eigen::Isometry3d& T) { return std::atan2(T(1, 0), T(0, 0)); }

/** Straight on by so much, in steps. */
std::vector<Eigen::Isometry3d> straight(double distance, double step) {
  std::vector<Eigen::Isometry3d> poses;
  const int n = static_cast<int>(std::lround(distance / step));
  for (int i = 0; i <= n; ++i) {
    poses.emplace_back(Eigen::Isometry3d::Identity());
    poses.back().translation().x() = i * step;
  }
  return poses;
}

std::vector<Eigen::Isometry3d> turning(double angle, double step) {
  std::vector<Eigen::Isometry3d> poses;
  const int n = static_cast<int>(std::lround(angle / step));
  for (int i = 0; i <= n; ++i) {
    poses.emplace_back(Eigen::Isometry3d::Identity());
    poses.back().linear() = expSO3({0, 0, i * step});
  }
  return poses;
}

/** Root mean squares over many runs, of the error at the end. */
struct Spread {
  double ahead = 0, heading_deg = 0;
};

Spread spreadOf(const std::vector<Eigen::Isometry3d>& truth, const WheelOdometryParams& params) {
  Spread spread;
  for (int seed = 0; seed < kRuns; ++seed) {
    const Eigen::Isometry3d end =
        simulateOdometry(truth, params, RobotParams{}, static_cast<std::uint64_t>(seed)).back();
    const Eigen::Isometry3d error = truth.back().inverse() * end;
    spread.ahead += std::pow(error.translation().x(), 2) / kRuns;
    spread.heading_deg += std::pow(headingOf(error) / kDegree, 2) / kRuns;
  }
  return {std::sqrt(spread.ahead), std::sqrt(spread.heading_deg)};
}

WheelOdometryParams only(double WheelOdometryParams::*error) {
  WheelOdometryParams params;
  for (double WheelOdometryParams::*other :
       {&WheelOdometryParams::scale_std, &WheelOdometryParams::length_std,
        &WheelOdometryParams::heading_std_deg})
    if (other != error) params.*other = 0;
  return params;
}

constexpr double kStatistical = 0.05;  // more than four times 1/sqrt(2 kRuns)

TEST(SimulatedOdometry, TheHeadingWalksAtRandom) {
  const WheelOdometryParams params = only(&WheelOdometryParams::heading_std_deg);
  for (const double step : {0.1, 0.25, 0.5}) {
    EXPECT_NEAR(spreadOf(straight(1, step), params).heading_deg, 1, kStatistical) << step;
    EXPECT_NEAR(spreadOf(straight(9, step), params).heading_deg, 3, 3 * kStatistical) << step;
  }
}

TEST(SimulatedOdometry, OneScaleIsWrongForAWholeRun) {
  const WheelOdometryParams params = only(&WheelOdometryParams::scale_std);
  for (const double distance : {1.0, 20.0})
    EXPECT_NEAR(spreadOf(straight(distance, 0.25), params).ahead, 0.02 * distance,
                kStatistical * 0.02 * distance)
        << distance;
}

TEST(SimulatedOdometry, LengthsAreNoisyByTheRootOfTheDistance) {
  const WheelOdometryParams params = only(&WheelOdometryParams::length_std);
  for (const double step : {0.1, 0.5}) {
    EXPECT_NEAR(spreadOf(straight(1, step), params).ahead, 0.01, kStatistical * 0.01) << step;
    EXPECT_NEAR(spreadOf(straight(4, step), params).ahead, 0.02, kStatistical * 0.02) << step;
  }
}

TEST(SimulatedOdometry, ATurnOnTheSpotRollsTheWheels) {
  const double rolled = RobotParams{}.wheel_track / 2 * 2 * EIGEN_PI;
  EXPECT_NEAR(spreadOf(turning(2 * EIGEN_PI, 5 * kDegree), {}).heading_deg, std::sqrt(rolled),
              kStatistical * std::sqrt(rolled));
}

TEST(SimulatedOdometry, WithoutErrorsItIsTheTruthOnTheFloor) {
  DriveParams drive;
  drive.sway_deg = 10;
  const Route square = {{{0, 0}, 90}, {{2, 0}, 0}, {{2, 2}, 0}, {{0, 2}, 0}};
  const auto truth = basePoses(simulateDrive(square, 200, drive, 7), drive.mounting());
  const auto told = simulateOdometry(truth, only(nullptr), RobotParams{}, 3);
  ASSERT_EQ(told.size(), truth.size());
  EXPECT_TRUE(told[0].isApprox(Eigen::Isometry3d::Identity()));
  const auto place = [](const Eigen::Isometry3d& T) -> Eigen::Vector2d { return T.translation().head<2>(); };
  const Eigen::Rotation2Dd to_first(-headingOf(truth[0]));
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_NEAR((place(told[i]) - to_first * (place(truth[i]) - place(truth[0]))).norm(), 0, 1e-9) << i;
    EXPECT_NEAR(std::remainder(headingOf(told[i]) - headingOf(truth[i]) + headingOf(truth[0]), 2 * EIGEN_PI),
                0, 1e-9)
        << i;
    EXPECT_EQ(told[i].translation().z(), 0);
    EXPECT_NEAR(told[i](2, 2), 1, 1e-12) << "it is level";
  }
}

TEST(SimulatedOdometry, SeedsSelectErrors) {
  const auto truth = straight(3, 0.25);
  const auto a = simulateOdometry(truth, {}, {}, 1), b = simulateOdometry(truth, {}, {}, 1),
             c = simulateOdometry(truth, {}, {}, 2);
  EXPECT_EQ(a.back().matrix(), b.back().matrix());
  EXPECT_NE(a.back().matrix(), c.back().matrix());
  EXPECT_TRUE(simulateOdometry({}, {}, {}, 1).empty());
}

/** Straight on, 0.1 m a step, to and fro. */
std::vector<Eigen::Isometry3d> drive(int n) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < n; ++i)
    poses.emplace_back(Eigen::Translation3d(0.1 * (i < n / 2 ? i : n - i), 1, 2) *
                       Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
  return poses;
}

MapPoseErrors errors() {
  MapPoseErrors errors;
  errors.translation_std = 0.03, errors.rotation_std_deg = 1;
  return errors;
}

TEST(SimulatedMapPoses, HaveErrorsOfThatSize) {
  const auto truth = drive(20000), poses = simulateMapPoses(truth, errors(), 3);
  ASSERT_EQ(poses.size(), truth.size());
  Vector6d squares = Vector6d::Zero();
  for (std::size_t i = 0; i < truth.size(); ++i)
    squares += boxminus(poses[i], truth[i]).cwiseAbs2() / static_cast<double>(truth.size());
  for (int axis = 0; axis < 6; ++axis)
    EXPECT_NEAR(std::sqrt(squares[axis]) / (axis < 3 ? kDegree : 0.03), 1, 0.1) << axis;
}

TEST(SimulatedMapPoses, AgreeWithTheirNeighboursAndNotWhereAPlaceIsPassedAgain) {
  const auto truth = drive(2000), poses = simulateMapPoses(truth, errors(), 3);
  double step = 0, again = 0;
  for (std::size_t i = 1; i < truth.size() / 2; ++i) {
    const auto error = [&](std::size_t k) {
      return (poses[k].translation() - truth[k].translation()).eval();
    };
    step = std::max(step, (error(i) - error(i - 1)).norm());
    again += (error(i) - error(truth.size() - i)).norm() / (truth.size() / 2.0 - 1);
  }
  EXPECT_LT(step, 0.02) << "0.1 m of waves of 3 m and more";
  EXPECT_GT(again, 0.03);
}

TEST(SimulatedMapPoses, SameSeedSameErrors) {
  const auto truth = drive(50);
  const auto a = simulateMapPoses(truth, errors(), 3), b = simulateMapPoses(truth, errors(), 3);
  const auto c = simulateMapPoses(truth, errors(), 4);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_EQ(a[i].matrix(), b[i].matrix());
    EXPECT_NE(a[i].matrix(), c[i].matrix());
  }
}

TEST(SimulatedMapPoses, WithoutErrorsTheyAreTrue) {
  const auto truth = drive(50), poses = simulateMapPoses(truth, {}, 3);
  EXPECT_FALSE(MapPoseErrors().any());
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_TRUE(poses[i].isApprox(truth[i], 1e-14));
  MapPoseErrors negative;
  negative.translation_std = -1;
  EXPECT_THROW(simulateMapPoses(truth, negative, 3), std::invalid_argument);
}

}  // namespace
}  // namespace facetloc
