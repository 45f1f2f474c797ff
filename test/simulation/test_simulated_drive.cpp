// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_drive.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace facetloc {
namespace {

class SimulatedDrive : public testing::TestWithParam<int> {
protected:
  const SimulatedWorld scene_ = randomRoom(GetParam());
};

TEST_P(SimulatedDrive, StaysInsideAndClearOfWalls) {
  Eigen::AlignedBox3d room;
  for (const Rectangle& r : scene_.rectangles) room.extend(r.centre);
  DriveParams even;
  even.robot.floor_std = 0;
  const double clear = even.clearance - 0.01;
  for (const Eigen::Isometry3d& T_w_c : simulateDrive(scene_, 150, even, GetParam())) {
    const Eigen::Vector3d t = T_w_c.translation();
    EXPECT_GT(t.x(), room.min().x() + clear);
    EXPECT_LT(t.x(), room.max().x() - clear);
    EXPECT_GT(t.y(), room.min().y() + clear);
    EXPECT_LT(t.y(), room.max().y() - clear);
    EXPECT_NEAR(t.z(), even.camera_height, 1e-9);
    EXPECT_NEAR(T_w_c.linear().col(2).z(), -std::sin(even.camera_tilt_deg * kDegree), 1e-9);
  }
}

TEST_P(SimulatedDrive, AnUnevenFloorTiltsTheCamera) {
  const DriveParams params;
  double squares = 0;
  const auto poses = simulateDrive(scene_, 400, params, GetParam());
  for (const Eigen::Isometry3d& T_w_c : poses) {
    const double pitch = std::asin(-T_w_c.linear().col(2).z()) / kDegree - params.camera_tilt_deg;
    squares += pitch * pitch;
  }
  // The tilt of a base on three points of independent height: Var(w_y) = 3 sigma_f^2 / (2 b^2)
  const double expected = params.robot.floor_std * std::sqrt(1.5) / params.robot.caster_distance / kDegree;
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(poses.size())), expected, 0.15 * expected);
}

TEST_P(SimulatedDrive, StepsAreSmall) {
  DriveParams even;
  even.robot.floor_std = 0;
  const auto poses = simulateDrive(scene_, 150, even, GetParam());
  ASSERT_EQ(poses.size(), 150u);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Isometry3d step = poses[i - 1].inverse() * poses[i];
    EXPECT_LE(step.translation().norm(), even.step + 1e-9);
    EXPECT_LE(rotationAngle(step.linear()), even.turn_deg * kDegree + 1e-9);
  }
}

TEST_P(SimulatedDrive, SeedsSelectDrives) {
  const auto a = simulateDrive(scene_, 20, {}, 1), b = simulateDrive(scene_, 20, {}, 1),
             c = simulateDrive(scene_, 20, {}, 2);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].matrix(), b[i].matrix());
    EXPECT_NE(a[i].matrix(), c[i].matrix());
  }
}

TEST_P(SimulatedDrive, InTimeItKeepsToItsSpeeds) {
  DriveParams even;
  even.robot.floor_std = 0, even.sway_deg = 10;
  const PaceParams pace;
  const auto poses = simulateDrive(scene_, 900, even, GetParam(), {}, pace);
  ASSERT_EQ(poses.size(), 900u);
  const double step = pace.speed / pace.rate, turn = pace.turn_rate_deg * kDegree / pace.rate;
  const double sway = even.sway_deg * kDegree * 2 * EIGEN_PI / kSwayLength * step;
  int driving = 0, turning = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Isometry3d motion = poses[i - 1].inverse() * poses[i];
    const double shift = motion.translation().norm(), angle = rotationAngle(motion.linear());
    EXPECT_LE(shift, step + 1e-9);
    EXPECT_LE(angle, turn + sway + 1e-9);
    driving += shift > 0.999 * step;
    turning += shift < 1e-9 && angle > 0.999 * turn;
  }
  EXPECT_GT(driving, 100);
  EXPECT_GT(turning, 100);
  EXPECT_GT(driving + turning, 850);  // the robot never rests
}

TEST_P(SimulatedDrive, TheRateSelectsImagesOfOneDrive) {
  PaceParams slow, fast;
  slow.rate = 10;
  fast.rate = 30;
  const auto few = simulateDrive(scene_, 100, {}, GetParam(), {}, slow);
  const auto many = simulateDrive(scene_, 300, {}, GetParam(), {}, fast);
  for (std::size_t i = 0; i < few.size(); ++i) EXPECT_TRUE(few[i].isApprox(many[3 * i], 1e-6)) << i;
}

TEST_P(SimulatedDrive, InTimeTheTiltOfAnUnevenFloorIsSmooth) {
  const DriveParams params;
  const auto poses = simulateDrive(scene_, 1800, params, GetParam(), {}, PaceParams{});
  const auto pitch = [&](std::size_t i) { return std::asin(-poses[i].linear().col(2).z()) / kDegree; };
  double squares = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    squares += std::pow(pitch(i) - params.camera_tilt_deg, 2) / static_cast<double>(poses.size());
    EXPECT_LT(std::abs(pitch(i) - pitch(i > 0 ? i - 1 : 0)), 1) << i;
  }
  // Three independent wheels are the limit of short waves.
  const double independent = params.robot.floor_std * std::sqrt(1.5) / params.robot.caster_distance / kDegree;
  EXPECT_GT(std::sqrt(squares), 0.3 * independent);
  EXPECT_LT(std::sqrt(squares), 1.3 * independent);
}

INSTANTIATE_TEST_SUITE_P(Rooms, SimulatedDrive, testing::Range(1, 6));

TEST(SimulatedRoute, DrivenInTimeItIsTheSameAsInSteps) {
  const Route square = {{{0, 0}, 90}, {{2, 0}, 0}, {{2, 2}, 0}, {{0, 2}, 0}};
  DriveParams even;
  even.robot.floor_std = 0;
  const auto poses = simulateDrive(square, 30 * 60, even, 1, PaceParams{});
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(2, 0), {2, 2}, {0, 2}, {0, 0}}) {
    double nearest = 10;
    for (const auto& T : poses) nearest = std::min(nearest, (T.translation().head<2>() - corner).norm());
    EXPECT_LT(nearest, 0.02);
  }
  // 8 m at 0.5 m/s and 360 deg at 45 deg/s: 24 s a round
  EXPECT_LT((poses[0].translation() - poses[30 * 24].translation()).norm(), 0.05);
}

TEST(SimulatedRoute, WheelsDoNotSlipSidewaysInTime) {
  DriveParams swaying;
  swaying.robot.floor_std = 0, swaying.sway_deg = 10;
  const Route there_and_back = {{{0, 0}, 0}, {{6, 0}, 0}};
  const auto poses = simulateDrive(there_and_back, 300, swaying, 3, PaceParams{});
  double farthest = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Isometry3d step = poses[i - 1].inverse() * poses[i];
    // Camera axes: x is to the right. The sine and the tangent of 10 deg differ by 1.5 %.
    EXPECT_NEAR(step.translation().x(), 0, 0.02 * step.translation().norm() + 1e-9) << i;
    farthest = std::max(farthest, std::abs(poses[i].translation().y()));
  }
  EXPECT_GT(farthest, 0.1);  // it weaves about the line
}

TEST(SimulatedRoute, MayEndAtItsLastWaypoint) {
  const Route there = {{{0, 0}, 0}, {{3, 0}, 0}};
  DriveParams even;
  even.robot.floor_std = 0;
  const auto poses = simulateDrive(there, 1000, even, 1, {}, RouteEnd::stop);
  ASSERT_EQ(poses.size(), 7u);  // every 0.5 m
  EXPECT_NEAR(poses.back().translation().x(), 3, 1e-9);
  EXPECT_EQ(simulateDrive(there, 1000, even, 1).size(), 1000u);
}

TEST(SimulatedRoute, FurtherRoundsAreOnOtherLines) {
  const Route square = {{{0, 0}, 90}, {{2, 0}, 0}, {{2, 2}, 0}, {{0, 2}, 0}};
  const Route rounds = roundsOf(square, 3, 5);
  ASSERT_EQ(rounds.size(), 12u);
  for (std::size_t i = 0; i < rounds.size(); ++i) {
    EXPECT_EQ(rounds[i].look_deg, square[i % 4].look_deg);
    const Eigen::Vector2d moved = rounds[i].place - square[i % 4].place;
    if (i < 4)
      EXPECT_EQ(moved, Eigen::Vector2d(0, 0)) << "the first one as it is";
    else
      EXPECT_GT(moved.norm(), 0);
    EXPECT_LE(moved.cwiseAbs().maxCoeff(), 0.1);
  }
  EXPECT_NE(rounds[4].place, rounds[8].place);
  EXPECT_EQ(roundsOf(square, 3, 5).back().place, rounds.back().place);
  EXPECT_NE(roundsOf(square, 3, 6).back().place, rounds.back().place);
}

TEST(SimulatedRoute, StepsTakeTheTimeOfTheirDistanceOrTurn) {
  const auto standing = [](double x, double yaw_deg) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() << x, 0, 0.003 * x;  // an uneven floor takes no time
    T.linear() = expSO3({0, 0, yaw_deg * kDegree}) * expSO3({0.01 * x, 0.02, 0});
    return T;
  };
  const auto times = drivingTimes({standing(0, 0), standing(0.25, 0), standing(0.25, 9), standing(0.5, 81),
                                   standing(0.501, 81), standing(0.501, -171)});
  ASSERT_EQ(times.size(), 6u);
  constexpr double kTilted = 1e-3;  // [s] tilts and headings mix a little
  EXPECT_EQ(times[0], 0);
  EXPECT_NEAR(times[1] - times[0], 0.5, kTilted);
  EXPECT_NEAR(times[2] - times[1], 0.2, kTilted);
  EXPECT_NEAR(times[3] - times[2], 1.6, kTilted) << "the longer of both";
  EXPECT_NEAR(times[4] - times[3], 1 / 30., kTilted) << "the camera takes no more images";
  EXPECT_NEAR(times[5] - times[4], 108 / 45., kTilted) << "the shorter way round";
  EXPECT_TRUE(drivingTimes({}).empty());
}

TEST(SimulatedDriveErrors, ARoomWithoutSpaceIsReported) {
  DriveParams params;
  params.clearance = 10;
  EXPECT_THROW(simulateDrive(randomRoom(1), 10, params, 1), std::runtime_error);
}

void expectSame(const std::vector<Eigen::Isometry3d>& a, const std::vector<Eigen::Isometry3d>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].matrix(), b[i].matrix()) << i;
}

TEST(SimulatedRun, DrivesTheRouteOfItsRun) {
  const SimulatedPlace office = simulatedPlace("office", 3);
  expectSame(simulatedRun("office", 3, kMappingRun, 20, {}).poses,
             simulateDrive(office.mapping_route, 20, {}, 3 * 64));
  const SimulatedRun later = simulatedRun("office", 3, kLaterRun, 20, {});
  expectSame(later.poses, simulateDrive(office.query_route, 20, {}, 3 * 64 + 1));
  EXPECT_EQ(later.world.rectangles.size(), office.later.rectangles.size());
}

TEST(SimulatedRun, EndsWhereAOneWayRouteEndsUnlessItReturns) {
  const std::size_t frames = 1000;
  EXPECT_LT(simulatedRun("corridor", 1, kMappingRun, frames, {}).poses.size(), frames);
  EXPECT_EQ(simulatedRun("corridor", 1, kMappingRun, frames, {}, {}, RouteEnd::go_round).poses.size(),
            frames);
}

TEST(SimulatedRun, ARoomIsThatOfItsSeed) {
  const SimulatedRun run = simulatedRun(kRoomName, 5, kLaterRun, 10, {});
  EXPECT_EQ(run.world.rectangles.size(), furnishedRoom(5).rectangles.size());
  expectSame(run.poses, simulateDrive(furnishedRoom(5), 10, {}, runSeed(5, kLaterRun)));
  EXPECT_THROW(simulatedRun("cellar", 1, kMappingRun, 10, {}), std::invalid_argument);
}

TEST(SimulatedRun, TheKinectsCentreIsInTheMiddle) {
  const Intrinsics half = centredKinect(320);
  EXPECT_EQ(half.width, 320);
  EXPECT_EQ(half.height, 240);
  EXPECT_DOUBLE_EQ(half.cx, 159.5);
  EXPECT_DOUBLE_EQ(half.cy, 119.5);
  EXPECT_DOUBLE_EQ(half.fx, kinectIntrinsics().fx / 2);
}

}  // namespace
}  // namespace facetloc
