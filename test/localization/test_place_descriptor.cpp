// SPDX-License-Identifier: BSD-3-Clause
#include "base/lanes.h"
#include "shortlist/place_descriptor.h"

#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace facetloc {

using namespace internal;
namespace {

constexpr CameraMounting kMounting{1.0, 10.0};

// A robot at (x, y) that looks along a heading, its floor tilted by roll and pitch [rad].
Eigen::Isometry3d robotCamera(double x, double y, double heading, double roll = 0, double pitch = 0) {
  return Eigen::Translation3d(x, y, 0) *
         Eigen::Isometry3d(expSO3({0, 0, heading}) * expSO3({roll, pitch, 0})) * kMounting.T_b_c();
}

// The wall whose normal has that heading in the world, the farthest of them.
const Wall* wallFacing(const PlaceDescriptor& place, double robot_heading, double world_heading) {
  const Wall* farthest = nullptr;
  for (const Wall& w : place.walls) {
    if (std::abs(std::remainder(w.heading + robot_heading - world_heading, 360 * kDegree)) > 3 * kDegree)
      continue;
    if (!farthest || w.offset > farthest->offset) farthest = &w;
  }
  return farthest;
}

TEST(PlaceDescriptor, WallsLieWhereTheRoomHasThem) {
  // The room's wall x = 6 is seen from x = 2: at 4 m, whatever the heading.
  for (const double heading : {-0.3, 0.0, 0.3}) {
    const PlaceDescriptor place =
        placeDescriptor(viewFrom(test::largeRoom(), robotCamera(2, 2.5, heading), 1), kMounting);
    const Wall* wall = wallFacing(place, heading, 0);
    ASSERT_NE(wall, nullptr) << heading;
    EXPECT_NEAR(wall->offset, 4, 0.05) << heading;
    EXPECT_NEAR(wall->heading, -heading, 1 * kDegree);
    EXPECT_NEAR(wall->cosine, std::cos(wall->heading), 1e-6);
    EXPECT_NEAR(wall->sine, std::sin(wall->heading), 1e-6);
    EXPECT_LE(wall->right, wall->left);
    EXPECT_LE(wall->bottom, wall->top);
  }
}

TEST(PlaceDescriptor, WallsThatFaceAMainHeadingComeFirst) {
  for (const double heading : {-2.0, -0.7, 0.1, 0.6, 0.9, 2.5}) {
    const PlaceDescriptor place =
        placeDescriptor(viewFrom(test::largeRoom(), robotCamera(2, 2.5, heading), 1), kMounting);
    // The room's walls are along its axes.
    EXPECT_NEAR(std::remainder(place.main_heading + heading, 90 * kDegree), 0, 1 * kDegree) << heading;
    EXPECT_LE(std::abs(place.main_heading), 45 * kDegree + 1e-6) << heading;
    EXPECT_EQ(place.facing.front(), 0);
    ASSERT_TRUE(std::is_sorted(place.facing.begin(), place.facing.end()));
    ASSERT_LE(place.facing.back(), static_cast<std::int32_t>(place.walls.size()));
    EXPECT_GE(place.facing.back(), 3) << heading;
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(place.walls.size()); ++i)
      for (int k = 0; k < 4; ++k) {
        const double turn =
            std::remainder(place.walls[i].heading - place.main_heading - k * 90 * kDegree, 360 * kDegree);
        const bool listed = place.facing[k] <= i && i < place.facing[k + 1];
        EXPECT_EQ(listed, std::abs(turn) <= 8 * kDegree) << heading << ", wall " << i << ", " << k;
      }
  }
}

TEST(WallColumns, UnseenEndsAreInfinite) {
  Wall w;
  w.offset = 3, w.right = -1, w.left = 2, w.bottom = 0.5f, w.top = 1.5f, w.weight = 0.8f;
  w.left_end = w.top_end = true;
  const WallColumns columns({w, w, w});
  EXPECT_EQ(columns.size() % kLanes, 0u);
  EXPECT_GE(columns.size(), 3u);
  EXPECT_EQ(columns.offset[2], 3);
  EXPECT_EQ(columns.weight[2], 0.8f);
  EXPECT_EQ(columns.right[2], -1);
  EXPECT_EQ(columns.seen_left[2], 2);
  EXPECT_EQ(columns.seen_top[2], 1.5f);
  EXPECT_TRUE(std::isnan(columns.seen_right[2]));
  EXPECT_TRUE(std::isnan(columns.seen_bottom[2]));
  ASSERT_GE(columns.offset.size(), columns.size() + kLanes);  // a whole vector from any wall on
  EXPECT_TRUE(std::isnan(columns.offset[3]));
  EXPECT_TRUE(std::isnan(columns.offset.back()));
}

TEST(PlaceDescriptor, AnUnevenFloorChangesLittle) {
  const double roll = 1 * kDegree, pitch = 2 * kDegree;
  const Eigen::Isometry3d tilted = robotCamera(2, 2.5, 0.1, roll, pitch);
  const PlaceDescriptor place = placeDescriptor(viewFrom(test::largeRoom(), tilted, 2), kMounting);
  const Wall* wall = wallFacing(place, 0.1, 0);
  ASSERT_NE(wall, nullptr);
  EXPECT_NEAR(wall->offset, 6 - tilted.translation().x(), 0.05);
  // The upright frame is the world's but for the heading: its z axis in camera axes is the world's.
  const Eigen::Vector3d up = place.R_u_c.cast<double>().transpose() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d truth = tilted.linear().transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_LT(std::acos(std::min(1.0, up.dot(truth))), 0.6 * kDegree);
}

TEST(PlaceDescriptor, LevelSurfacesHaveTheHeightOfTheFurniture) {
  // The low box in the corner, 0.5 m high, from two places.
  for (const double distance : {0.9, 1.2}) {
    const View view = viewFrom(test::largeRoom(), robotCamera(0.7 + distance, 1.3, 180 * kDegree), 3);
    const PlaceDescriptor place = placeDescriptor(view, kMounting);
    EXPECT_TRUE(std::any_of(place.surfaces.begin(), place.surfaces.end(), [](const LevelSurface& s) {
      return !s.from_below && std::abs(s.height - 0.5) < 0.03;
    })) << distance;
    for (const LevelSurface& s : place.surfaces) EXPECT_GT(std::abs(s.height), 0.04);  // the floor is none
  }
}

TEST(PlaceDescriptor, PointsLieAboveTheFloorAndInTheRoom) {
  const Eigen::Isometry3d T_w_c = robotCamera(2, 2.5, 0.2);
  const PlaceDescriptor place = placeDescriptor(viewFrom(test::largeRoom(), T_w_c, 4), kMounting);
  PointColumns points;
  pointsAboveFloor(place, points);
  ASSERT_GT(points.size(), 20u);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p(points.x[i], points.y[i], points.z[i]);
    EXPECT_GT(p.z() + place.height, 0);
    EXPECT_LT(p.z() + place.height, 2.7);
    const Eigen::Vector3d w = expSO3({0, 0, 0.2}) * p.cast<double>() + T_w_c.translation();
    EXPECT_GT(w.x(), -0.4);
    EXPECT_LT(w.x(), 6.4);
  }
}

TEST(PlaceDescriptor, BadSegmentsAreLeftOut) {
  View view = viewFrom(test::largeRoom(), robotCamera(2, 2.5, 0), 5);
  const PlaceDescriptor sound = placeDescriptor(view, kMounting);
  Segment bad = view.segments.front();
  bad.t.x() = std::numeric_limits<double>::quiet_NaN();
  view.segments.push_back(bad);
  const PlaceDescriptor place = placeDescriptor(view, kMounting);
  EXPECT_EQ(place.walls.size(), sound.walls.size());
  EXPECT_EQ(place.R_u_c, sound.R_u_c);
  EXPECT_EQ(place.height, sound.height);

  const PlaceDescriptor nothing = placeDescriptor(View{}, kMounting);
  EXPECT_TRUE(nothing.walls.empty());
  EXPECT_TRUE(nothing.surfaces.empty());
  PointColumns points;
  points.resize(1);
  pointsAboveFloor(nothing, points);
  EXPECT_EQ(points.size(), 0u);
}

TEST(PlaceDescriptor, APictureWithoutPixelsHasNoSize) {
  PlaceDescriptor place = placeDescriptor(viewFrom(test::largeRoom(), robotCamera(2, 2.5, 0), 6), kMounting);
  EXPECT_TRUE(isSound(place));
  place.picture.depth.clear();
  EXPECT_FALSE(isSound(place));
  place.picture = {};
  EXPECT_TRUE(isSound(place));
}

}  // namespace
}  // namespace facetloc
