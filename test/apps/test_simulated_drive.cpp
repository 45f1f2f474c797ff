// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/simulated_drive.h>
#include <facetloc/features/so3.h>

#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {
namespace {

class SimulatedDrive : public testing::TestWithParam<int> {
protected:
  const Scene scene_ = randomRoom(GetParam());
};

TEST_P(SimulatedDrive, StaysInsideAndClearOfWalls) {
  Eigen::AlignedBox3d room;
  for (const Rectangle& r : scene_.rectangles) room.extend(r.centre);
  DriveParams even;
  even.floor_std = 0;
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
  // METHOD eq. (6.1): Var(w_y) = 3 sigma_f^2 / (2 b^2)
  const double expected = params.floor_std * std::sqrt(1.5) / params.caster_distance / kDegree;
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(poses.size())), expected, 0.15 * expected);
}

TEST_P(SimulatedDrive, StepsAreSmall) {
  DriveParams even;
  even.floor_std = 0;
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

INSTANTIATE_TEST_SUITE_P(Rooms, SimulatedDrive, testing::Range(1, 6));

TEST(SimulatedDriveErrors, ARoomWithoutSpaceIsTold) {
  DriveParams params;
  params.clearance = 10;
  EXPECT_THROW(simulateDrive(randomRoom(1), 10, params, 1), std::runtime_error);
}

}  // namespace
}  // namespace facetloc
