// SPDX-License-Identifier: BSD-3-Clause
#include "belief/map_surroundings.h"

#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/changed_views.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

namespace facetloc {
namespace {

using namespace internal;
using test::largeRoom, test::lookingAlong, test::viewFrom, testing::ElementsAre;

LocalModel modelAt(const Eigen::Isometry3d& T_w_m, unsigned seed) {
  return {"", 0, T_w_m, viewFrom(largeRoom(), T_w_m, seed)};
}

class SurroundingsOfAPose : public testing::Test {
protected:
  SurroundingsOfAPose() {
    map->models.push_back(modelAt(lookingAlong({3, 2.5, 1.2}, {1, 0, -0.2}), 1));
    map->models.push_back(modelAt(lookingAlong({3.5, 2.5, 1.2}, {1, 0.1, -0.2}), 2));
    map->models.push_back(modelAt(lookingAlong({3, 2.5, 1.2}, {-1, 0, -0.2}), 3));  // the other way
    map->models.push_back(modelAt(lookingAlong({3, 2.5, 1.2}, {1, 0, -0.2}), 4));
    map->models.back().T_w_m.reset();  // its pose is unknown
  }
  MapSurroundings surroundings() const { return MapSurroundings(map, DepthComparison({})); }
  static std::vector<int> viewsOf(const LocalMap& found) {
    std::vector<int> views;
    for (const LocalMap::Origin& o : found.origins)
      if (views.empty() || views.back() != o.view) views.push_back(o.view);
    return views;
  }

  const Eigen::Isometry3d pose = lookingAlong({3.1, 2.5, 1.2}, {1, 0.02, -0.2});
  const View view = viewFrom(largeRoom(), pose, 9);
  std::shared_ptr<Map> map = std::make_shared<Map>();
};

TEST_F(SurroundingsOfAPose, AreTheNearestModels) {
  const MapSurroundings all = surroundings();
  const LocalMap found = all.around(view, 0, pose, 5);
  EXPECT_THAT(viewsOf(found), ElementsAre(0, 1));
  EXPECT_EQ(found.pictures.size(), 2u);
  EXPECT_THAT(viewsOf(all.around(view, 0, pose, 1)), ElementsAre(0));
  Eigen::Isometry3d far = pose;
  far.translation().x() += 100;
  EXPECT_TRUE(all.around(view, 0, far, 5).segments.empty());
}

TEST_F(SurroundingsOfAPose, WithoutDepthAreTheNearest) {
  test::changeViews(*map, [](View& changed) { changed.depth = {}; });
  const LocalMap found = surroundings().around(view, 0, pose, 1);
  EXPECT_THAT(viewsOf(found), ElementsAre(0));
  EXPECT_TRUE(found.pictures.empty());
}

TEST_F(SurroundingsOfAPose, AModelBehindAWallGivesNoPicture) {
  // The same pose, but the surfaces of that model are nearer than all that the view sees.
  map->models[0].setView(viewFrom(test::box({2.5, 2, 0}, {3.9, 3, 2.5}), *map->models[0].T_w_m, 5));
  const LocalMap found = surroundings().around(view, 0, pose, 5);
  ASSERT_EQ(found.pictures.size(), 1u);
  EXPECT_EQ(found.pictures[0].picture, &map->view(1)->depth);
  EXPECT_EQ(viewsOf(found).front(), 1);
}

TEST_F(SurroundingsOfAPose, HaveTheirSegmentsInTheWorld) {
  const LocalMap found = surroundings().around(view, 0, pose, 5);
  ASSERT_EQ(found.segments.size(), map->view(0)->segments.size() + map->view(1)->segments.size());
  ASSERT_EQ(found.origins.size(), found.segments.size());
  for (std::size_t i = 0; i < found.segments.size(); ++i) {
    const LocalModel& m = map->models[found.origins[i].view];
    const Segment& s = map->view(found.origins[i].view)->segments[found.origins[i].segment];
    EXPECT_LT((*m.T_w_m * s.t - found.segments[i].t).norm(), 1e-12);
    EXPECT_LT((m.T_w_m->linear() * s.R - found.segments[i].R).norm(), 1e-12);
  }
}

TEST_F(SurroundingsOfAPose, StandOnTheFloorOfTheNearestRobots) {
  const Eigen::Matrix3d covariance = floorCovariance({});
  EXPECT_FALSE(surroundings().floorNear(0, pose, 2, covariance));  // no mounting, no robot
  map->camera.mounting = CameraMounting{1.2, 0};
  map->models.resize(2);
  const auto standing = [](double x, double floor) {
    return Eigen::Translation3d(x, 0, floor) * CameraMounting{1.2, 0}.T_b_c();
  };
  map->models[0].T_w_m = standing(0, 0.1);
  map->models[1].T_w_m = standing(5, 0.3);
  const auto height = [&](double x, int n) {
    const FloorPlane floor = *surroundings().floorNear(0, standing(x, 0.1 + 0.04 * x), n, covariance);
    const Eigen::Vector3d normal = floor.T_w_f.linear().col(2);
    const Eigen::Vector3d to_plane = floor.T_w_f.translation() - Eigen::Vector3d(x, 0, 0);
    return normal.dot(to_plane) / normal.z();
  };
  EXPECT_NEAR(height(1, 1), 0.1, 1e-9);
  EXPECT_NEAR(height(4, 1), 0.3, 1e-9);
  const double between = height(4, 2);
  EXPECT_GT(between, 0.2);
  EXPECT_LT(between, 0.3);
  EXPECT_EQ(height(4, 9), between);
  // Robots on the storey above, and on a stage, have another floor.
  for (const auto& [x, floor] : {std::pair(3.9, 3.3), std::pair(4.1, 3.3), std::pair(4.2, 0.8)}) {
    map->models.push_back(map->models[0]);
    map->models.back().T_w_m = standing(x, floor);
  }
  EXPECT_NEAR(height(4, 9), between, 1e-9);
  EXPECT_FALSE(surroundings().floorNear(0, standing(4, 2), 2, covariance));
  for (LocalModel& m : map->models) m.T_w_m.reset();
  EXPECT_FALSE(surroundings().floorNear(0, standing(0, 0), 2, covariance));
}

TEST(MapSurroundings, OfAnEmptyMapAreEmpty) {
  const MapSurroundings none(std::make_shared<Map>(), DepthComparison({}));
  EXPECT_TRUE(none.around({}, 0, Eigen::Isometry3d::Identity(), 5).segments.empty());
}

}  // namespace
}  // namespace facetloc
