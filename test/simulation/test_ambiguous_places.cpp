// SPDX-License-Identifier: BSD-3-Clause
//
// Places that say little of where a camera is: a bare floor with boards, equal doors, a symmetric box.
#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_place.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

class AmbiguousPlaces : public testing::TestWithParam<int> {
protected:
  static SimulatedPlace place(const char* name) {
    return simulatedPlace(name, static_cast<std::uint64_t>(GetParam()));
  }
  static DepthImage seen(const SimulatedWorld& scene, const Eigen::Isometry3d& T_w_c) {
    return SimulatedCamera(kinectIntrinsics().subsampled(8), SimulatedNoise(), 1)
        .renderExact(scene, T_w_c)
        .depth;
  }
};

/** Looks along a heading, down by a tilt. */
Eigen::Isometry3d lookingFrom(double x, double y, double z, double heading, double tilt_deg = 0) {
  return Eigen::Translation3d(x, y, 0) * Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
         CameraMounting{z, tilt_deg}.T_b_c();
}

double difference(const DepthImage& a, const DepthImage& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.depth.size(); ++i)
    most = std::max(most, std::abs(static_cast<double>(a.depth[i]) - static_cast<double>(b.depth[i])));
  return most;
}

double highest(const Rectangle& r) {
  return r.centre.z() + std::abs(r.half_u * r.axis_u.z()) + std::abs(r.half_v * r.axis_v.z());
}

TEST_P(AmbiguousPlaces, OnTheBareFloorLieOnlyFlatBoards) {
  const SimulatedPlace boards = place("boards");
  int tops = 0;
  for (const Rectangle& r : boards.mapped.rectangles) {
    EXPECT_LE(highest(r), 0.03 + 1e-9);
    tops += r.centre.z() > 0.011 && std::abs(r.normal().z()) > 0.9;
  }
  EXPECT_GE(tops, 18);
  EXPECT_LE(tops, 24);
}

TEST_P(AmbiguousPlaces, BoardsAreInSightOfACameraThatLooksDown) {
  const SimulatedPlace boards = place("boards");
  DriveParams drive;
  drive.camera_tilt_deg = 60, drive.camera_height = 0.6;
  int with_boards = 0, images = 0;
  for (const Eigen::Isometry3d& T : simulateDrive(boards.query_route, 60, drive, 1)) {
    const SimulatedFrame frame =
        SimulatedCamera(kinectIntrinsics().subsampled(8), SimulatedNoise(), 1).renderExact(boards.later, T);
    ++images;
    with_boards +=
        std::any_of(frame.labels.label.begin(), frame.labels.label.end(), [](int l) { return l > 1; });
  }
  EXPECT_GT(with_boards, images / 2);
}

TEST_P(AmbiguousPlaces, DoorsAreAllEqual) {
  const SimulatedPlace doors = place("doors");
  constexpr double kSpacing = 1.8;
  int equal = 0;
  for (int door = 1; door + 1 < 15; ++door) {
    const auto at = [&](int d) {
      return seen(doors.mapped, lookingFrom((d + 0.5) * kSpacing, 0, 1, M_PI / 2));
    };
    equal += difference(at(door), at(door + 1)) < 1e-4;
  }
  EXPECT_GE(equal, 13 - 2 * 3) << "three things stand beside doors, each of which two images show";
  const DepthImage image = seen(doors.mapped, lookingFrom(2.5 * kSpacing, 0, 1, M_PI / 2));
  EXPECT_NEAR(image.at(40, 30), 1.2 - 0.02, 1e-3) << "the leaf of a door";
  const DepthImage between = seen(doors.mapped, lookingFrom(2 * kSpacing, 0, 2.3, M_PI / 2));
  EXPECT_NEAR(between.at(40, 30), 1.2 - 0.12, 1e-3) << "the wall";
}

TEST_P(AmbiguousPlaces, DoorsAreDrivenAlongOnce) {
  const SimulatedPlace doors = place("doors");
  EXPECT_TRUE(doors.one_way);
  for (const Route& route : {doors.mapping_route, doors.query_route}) {
    const auto poses = simulateDrive(route, 1000, {}, 1, {}, RouteEnd::stop);
    ASSERT_LT(poses.size(), 1000u);
    EXPECT_GT((poses.back().translation() - poses.front().translation()).norm(), 25);
  }
}

TEST_P(AmbiguousPlaces, TheBoxLooksTheSameFromOppositeSides) {
  const SimulatedPlace box = place("box");
  DriveParams drive;
  const Eigen::AngleAxisd half_turn(M_PI, Eigen::Vector3d::UnitZ()),
      quarter(M_PI / 2, Eigen::Vector3d::UnitZ());
  int box_seen = 0;
  for (const Eigen::Isometry3d& T : simulateDrive(box.mapping_route, 100, drive, 1)) {
    const DepthImage image = seen(box.mapped, T);
    EXPECT_LT(difference(image, seen(box.mapped, half_turn * T)), 1e-3);
    box_seen += difference(image, seen(box.mapped, quarter * T)) > 0.1;
  }
  EXPECT_GT(box_seen, 30);
}

TEST_P(AmbiguousPlaces, TheRobotKeepsClearOfTheBox) {
  const SimulatedPlace box = place("box");
  double widest = 0;
  for (const Rectangle& r : box.mapped.rectangles)
    if (highest(r) > 0.05)
      widest = std::max(widest, (r.centre.head<2>().norm() + std::max(r.half_u, r.half_v)));
  for (const Route& route : {box.mapping_route, box.query_route})
    for (const Eigen::Isometry3d& T : simulateDrive(route, 200, {}, 1))
      EXPECT_GT(T.translation().head<2>().norm(), widest + 0.05);
}

TEST_P(AmbiguousPlaces, DifferFromSeedToSeed) {
  for (const char* name : {"boards", "doors", "passage", "box"}) {
    const SimulatedPlace one = place(name), same = place(name);
    const SimulatedPlace other = simulatedPlace(name, static_cast<std::uint64_t>(GetParam()) + 1);
    const auto centres = [](const SimulatedPlace& p) {
      std::vector<Eigen::Vector3d> all;
      for (const Rectangle& r : p.mapped.rectangles) all.push_back(r.centre);
      return all;
    };
    EXPECT_EQ(centres(one), centres(same)) << name;
    EXPECT_NE(centres(one), centres(other)) << name;
    EXPECT_NE(one.mapping_route[0].place, one.query_route[0].place) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, AmbiguousPlaces, testing::Range(1, 5));

}  // namespace
}  // namespace facetloc
