// SPDX-License-Identifier: BSD-3-Clause
//
// Places that say little of where a camera is: a bare floor with boards, equal doors, a symmetric box.
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_place.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

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
  for (const char* name : {"corridor", "boards", "doors", "passage", "box"}) {
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

constexpr double kLength = 40;   // [m]
constexpr double kMaxDepth = 8;  // range of the camera [m]
constexpr std::size_t kMany = 1000;

DriveParams mappingDrive() {
  DriveParams params;
  params.step = 0.25;
  return params;
}

class BareCorridor : public testing::TestWithParam<int> {
protected:
  const SimulatedPlace place_ = simulatedPlace("corridor", static_cast<std::uint64_t>(GetParam()));
  const std::vector<Eigen::Isometry3d> poses_ =
      simulateDrive(place_.mapping_route, kMany, mappingDrive(), 1, {}, RouteEnd::stop);
};

TEST_P(BareCorridor, IsFloorCeilingAndFourWalls) {
  EXPECT_EQ(place_.mapped.rectangles.size(), 6u);
  EXPECT_TRUE(place_.mapped.bodies.empty());
  Eigen::AlignedBox3d box;
  for (const Rectangle& r : place_.mapped.rectangles) {
    box.extend(r.centre - r.half_u * r.axis_u - r.half_v * r.axis_v);
    box.extend(r.centre + r.half_u * r.axis_u + r.half_v * r.axis_v);
  }
  EXPECT_NEAR(box.sizes().x(), kLength, 1e-9);
  EXPECT_NEAR(box.sizes().y(), 2, 0.2 + 1e-9);
  EXPECT_NEAR(box.sizes().z(), 2.7, 0.3 + 1e-9);
}

TEST_P(BareCorridor, IsDrivenAlongOnce) {
  ASSERT_TRUE(place_.one_way);
  ASSERT_LT(poses_.size(), kMany);
  EXPECT_GT((poses_.back().translation() - poses_.front().translation()).norm(), 0.9 * kLength);
  for (std::size_t i = 1; i < poses_.size(); ++i)
    EXPECT_GT(poses_[i].translation().x(), poses_[i - 1].translation().x()) << i;
}

TEST_P(BareCorridor, MidwayTheEndsAreOutOfRange) {
  const Intrinsics eighth = kinectIntrinsics().subsampled(8);
  SimulatedNoise noise;
  noise.max_depth = kMaxDepth;
  const SimulatedCamera camera(eighth, noise, 1);
  const auto isEnd = [&](int label) {
    const auto r = std::find_if(place_.mapped.rectangles.begin(), place_.mapped.rectangles.end(),
                                [&](const Rectangle& one) { return one.plane_id == label; });
    return std::abs(r->normal().x()) > 0.5;
  };
  int midway = 0;
  for (std::size_t i = 0; i < poses_.size(); i += 10) {
    const double x = poses_[i].translation().x();
    if (x < kMaxDepth || x > kLength - kMaxDepth - 0.5) continue;
    ++midway;
    const SimulatedFrame frame = camera.render(place_.mapped, poses_[i], i);
    std::set<int> seen;
    for (std::size_t k = 0; k < frame.labels.label.size(); ++k)
      if (isMeasured(frame.depth.depth[k])) seen.insert(frame.labels.label[k]);
    seen.erase(0);
    EXPECT_GE(seen.size(), 3u) << x;
    EXPECT_TRUE(std::none_of(seen.begin(), seen.end(), isEnd)) << x;
  }
  EXPECT_GE(midway, 8);
}

INSTANTIATE_TEST_SUITE_P(Seeds, BareCorridor, testing::Range(1, 5));

constexpr double kRoomWidth = 4.4;  // [m]

/** A camera in a room on the left or right of the corridor, or in front of its door. */
Eigen::Isometry3d poseIn(int room, double side, double across, double heading) {
  const double x = (room + 0.5) * kRoomWidth;
  Eigen::Isometry3d T = Eigen::Isometry3d(Eigen::Translation3d(x, side * across, 1.2));
  const double a = (side > 0 ? 1 : -1) * std::acos(-1.0) / 2 + heading;
  const Eigen::Vector3d z(std::cos(a), std::sin(a), 0), down(0, 0, -1);
  T.linear().col(2) = z;
  T.linear().col(1) = down;
  T.linear().col(0) = down.cross(z);
  return T;
}

TEST(EqualRooms, AreEqualInsideAndDifferInTheCorridor) {
  const SimulatedPlace place = simulatedPlace("hotel", 1);
  SimulatedNoise noise;
  const SimulatedCamera camera(kinectIntrinsics().subsampled(8), noise, 1);
  const auto seen = [&](int room, double side, double across, double heading) {
    return camera.render(place.mapped, poseIn(room, side, across, heading), 0).depth;  // with the same noise
  };
  for (const double heading : {0.0, 1.2, -1.2}) {  // not towards the door
    const DepthImage first = seen(0, 1, 3.5, heading);
    for (int room = 1; room < 6; ++room) EXPECT_LT(difference(first, seen(room, 1, 3.5, heading)), 0.2);
    EXPECT_LT(difference(first, seen(2, -1, 3.5, heading)), 0.2);
  }
  for (int room = 1; room < 6; ++room)
    EXPECT_GT(difference(seen(0, 1, -0.9, 0), seen(room, 1, -0.9, 0)), 0.2) << "their doors differ";
}

}  // namespace
}  // namespace facetloc
