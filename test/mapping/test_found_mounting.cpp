// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/mounting_check.h"

#include <facetloc/mapping/map_findings.h>
#include <facetloc/testing/changed_views.h>

#include <gmock/gmock.h>

#include <random>

namespace facetloc {
namespace {

Segment plane(const Eigen::Vector3d& normal, double offset) {
  Segment s;
  s.R = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal.normalized()).toRotationMatrix();
  s.t = offset * normal.normalized();
  s.num_points = 1000;
  return s;
}

/** A plane of the floor's direction, seen by a camera that is mounted so. */
Segment level(const CameraMounting& mounting, double below) {
  return plane(-(mounting.T_b_c().linear().transpose() * Eigen::Vector3d::UnitZ()), below);
}

/** \param sway of height and tilt [m, deg], standard deviations */
Map drive(const CameraMounting& mounting, double sway_height, double sway_tilt, double distance) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Map map;
  for (int i = 0; i < 40; ++i) {
    CameraMounting now = mounting;
    now.height += sway_height * normal(random);
    now.tilt_deg += sway_tilt * normal(random);
    View view;
    view.segments = {level(now, now.height), level(now, now.height - 0.3 - 0.01 * i),
                     plane({0, 0, 1}, 2 + 0.1 * i)};
    map.models.emplace_back("", 0, Eigen::Isometry3d(Eigen::Translation3d(distance * i / 39, 0, 0)), view);
  }
  return map;
}

TEST(FoundMounting, IsThatOfARobotOnAnUnevenFloor) {
  const CameraMounting mounting{0.98, 10};
  const auto found = findMounting(drive(mounting, 0.004, 1.5, 10));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->mounting.height, 0.98, 0.01);
  EXPECT_NEAR(found->mounting.tilt_deg, 10, 1);
  EXPECT_THAT(found->toString(), testing::HasSubstr("of 40 local models"));
}

TEST(FoundMounting, IsFoundWhereTheViewsAreNotInMemory) {
  struct Store : MapStore {
    std::shared_ptr<const View> view(int i) const override { return map.view(i); }
    Map map = drive({0.98, 10}, 0.004, 1.5, 10);
  };
  const auto store = std::make_shared<Store>();
  Map stored = store->map;
  stored.setStore(store);
  EXPECT_EQ(findMounting(stored)->models, findMounting(store->map)->models);
}

TEST(FoundMounting, IsMissingForAHandheldCamera) {
  EXPECT_FALSE(findMounting(drive({1.3, 20}, 0.08, 8, 10)));
  EXPECT_FALSE(findMounting(drive({1.3, 20}, 0.03, 1, 10))) << "however straight it is held";
}

TEST(FoundMounting, NeedsACameraThatMoved) {
  EXPECT_FALSE(findMounting(drive({0.98, 10}, 0.004, 1.5, 0.5)));
  Map nowhere = drive({0.98, 10}, 0.004, 1.5, 10);
  for (LocalModel& model : nowhere.models) model.T_w_m.reset();
  EXPECT_FALSE(findMounting(nowhere));
  EXPECT_FALSE(findMounting(Map()));
}

TEST(FoundMounting, ARollIsPartOfIt) {
  CameraMounting mounting{0.98, 10};
  mounting.roll_deg = -15;
  const auto found = findMounting(drive(mounting, 0.004, 1.5, 10));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->mounting.height, 0.98, 0.01);
  EXPECT_NEAR(found->mounting.tilt_deg, 10, 1);
  EXPECT_NEAR(found->mounting.roll_deg, -15, 1);
  EXPECT_EQ(findMounting(drive({0.98, 10}, 0.004, 1.5, 10))->mounting.roll_deg, 0) << "a tiny roll is none";
}

TEST(SeenFloor, IsAlsoFoundForARolledCameraInTheHand) {
  Map map = drive({1.3, 20}, 0.02, 1, 0);
  constexpr double kRoll = 5;  // the camera's right side is lower
  const Eigen::Matrix3d R = Eigen::AngleAxisd(-kRoll * kDegree, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  test::changeViews(map, [&R](View& view) {
    for (Segment& s : view.segments) s.R = R * s.R, s.t = R * s.t;
  });
  const auto floor = findFloor(map);
  ASSERT_TRUE(floor);
  EXPECT_NEAR(floor->height, 1.3, 0.02);
  EXPECT_NEAR(floor->height_std, 0.02, 0.01);
  EXPECT_NEAR(floor->tilt_deg, 20, 1);
  EXPECT_NEAR(floor->roll_deg, kRoll, 0.5);
  EXPECT_FALSE(floor->steady);
  EXPECT_EQ(floor->all_views, 40);
  EXPECT_FALSE(findFloor(Map()));
}

TEST(Standing, IsShownByTheFloorOrByWalls) {
  const CameraMounting mounting{0.98, 10};
  const auto shows = [&](const std::vector<Segment>& segments) {
    View view;
    view.segments = segments;
    return internal::showsMounting(view, mounting);
  };
  const auto upright = [&](double heading, double lean_deg = 0) {
    const Eigen::Vector3d in_base(std::cos(heading), std::sin(heading), std::sin(lean_deg * kDegree));
    return plane(mounting.T_b_c().linear().transpose() * in_base, 2);
  };
  EXPECT_TRUE(shows({level(mounting, 0.98)}));
  EXPECT_TRUE(shows({level(mounting, 0.4)})) << "a table";
  EXPECT_FALSE(shows({level(mounting, 1.4)})) << "below the floor";
  EXPECT_FALSE(shows({level({0.98, 22}, 0.98)}));
  EXPECT_TRUE(shows({upright(0.1), upright(1.2)}));
  EXPECT_FALSE(shows({upright(0.1), upright(0.2)})) << "one of them alone";
  EXPECT_FALSE(shows({upright(0.1), upright(1.2, 12)}));
  EXPECT_FALSE(shows({}));
}

}  // namespace
}  // namespace facetloc
