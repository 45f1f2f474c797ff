// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/localization/localizer.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {
namespace {

using test::box, test::lookingAlong, test::Scene;

constexpr double kApart = 20;  // distance of the second room [m]
constexpr CameraMounting kMounting{1.2, 10};

Scene roomAt(double x) {
  return box({x, 0, 0}, {x + 6, 5, 2.5}) + box({x + 4.2, 3.1, 0}, {x + 5.3, 4.4, 0.8}) +
         box({x + 5.4, 0.8, 0}, {x + 6, 2.2, 1.1}) + box({x, 0.9, 0}, {x + 0.7, 1.7, 0.5});
}

/** A robot in the middle of the room, heading to the left of the x axis. */
Eigen::Isometry3d turnedBy(double degrees, double x = 0) {
  const double a = degrees * kDegree;
  return lookingAlong({x + 3, 2.5, kMounting.height},
                      {std::cos(a), std::sin(a), -std::tan(kMounting.tilt_deg * kDegree)});
}

View viewOf(const Scene& scene, const Eigen::Isometry3d& T_w_c, unsigned seed) {
  return test::mounted(test::viewFrom(scene, T_w_c, seed), kMounting);
}

/** Two equal rooms, of which the first has something more; a robot in it that sees no difference. */
struct EqualRooms {
  explicit EqualRooms(const Scene& difference) : scene(roomAt(0) + roomAt(kApart) + difference) {
    auto made = std::make_shared<Map>();
    made->camera.mounting = kMounting;
    for (const double x : {0.0, kApart})
      for (int k = 0; k < 24; ++k) {
        const Eigen::Isometry3d T_w_m = turnedBy(15 * k + 4, x);
        made->models.emplace_back("", 0, T_w_m, viewOf(scene, T_w_m, 100 + made->models.size()));
      }
    map = made;
  }
  Scene scene;
  std::shared_ptr<const Map> map;
};

TEST(NextLook, PointsToTheOnlySideOnWhichEqualRoomsDiffer) {
  struct Case {
    Scene difference;
    double least, most;  // turns that bring it into view [deg]
  };
  const Case cases[] = {{box({2.4, 4.3, 0}, {3.3, 5, 1.9}), 60, 120},
                        {box({2.6, 0, 0}, {3.5, 0.7, 1.9}), -120, -60}};
  for (const Case& c : cases) {
    const EqualRooms rooms(c.difference);
    Localizer localizer(rooms.map);
    const View first = viewOf(rooms.scene, turnedBy(0), 1);
    const Localization before = localizer.update(first, 0);
    ASSERT_EQ(before.state, AnswerState::doubtful);
    const std::optional<NextLook> look = localizer.nextLook(first, before);
    ASSERT_TRUE(look);
    EXPECT_GE(look->yaw / kDegree, c.least - 1e-6);
    EXPECT_LE(look->yaw / kDegree, c.most + 1e-6);
    EXPECT_EQ(look->ahead, 0);
    EXPECT_GT(look->gain, 0.3) << "of ln 2";

    const Eigen::Isometry3d T_w_c = turnedBy(look->yaw / kDegree);
    const PoseWithCovariance motion{turnedBy(0).inverse() * T_w_c, 1e-6 * Matrix6d::Identity()};
    const View second = viewOf(rooms.scene, T_w_c, 2);
    const Localization after = localizer.update(second, 1, motion);
    EXPECT_EQ(after.state, AnswerState::sure) << after.reason;
    EXPECT_TRUE(isNear(*after.hypotheses.front().T_w_c, T_w_c, 0.1, 2));
    EXPECT_FALSE(localizer.nextLook(second, after)) << "a sure answer needs none";
  }
}

TEST(NextLook, NothingDistinguishesRoomsThatAreEqualAllAround) {
  const EqualRooms rooms(Scene{});
  Localizer localizer(rooms.map);
  const View view = viewOf(rooms.scene, turnedBy(0), 1);
  const Localization answer = localizer.update(view, 0);
  ASSERT_NE(answer.state, AnswerState::sure);
  const std::optional<NextLook> look = localizer.nextLook(view, answer);
  EXPECT_LT(look ? look->sure : 0, 0.1);
}

TEST(NextLook, WithoutPlacesItPointsToWhereTheViewReachesFarther) {
  auto map = std::make_shared<Map>();
  map->models.emplace_back("", 0, turnedBy(0), viewOf(roomAt(0), turnedBy(0), 1));
  const Localizer localizer(map);
  for (const int side : {1, -1}) {
    const Scene wall = {test::endlessPlane({5, 2.5, 0}, {1, -0.5 * side, 0})};
    Localization unknown;
    unknown.searched = true;
    const std::optional<NextLook> look = localizer.nextLook(viewOf(wall, turnedBy(0), 2), unknown);
    ASSERT_TRUE(look);
    EXPECT_NEAR(look->yaw / kDegree, 30 * side, 1e-6);
    EXPECT_EQ(look->gain, 0);
  }
}

}  // namespace
}  // namespace facetloc
