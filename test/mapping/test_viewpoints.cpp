// SPDX-License-Identifier: BSD-3-Clause
#include "box_mesh.h"
#include "models/free_places.h"
#include "models/viewpoints.h"

#include <facetloc/features/pose.h>
#include <facetloc/mapping/mesh_surface.h>

#include <gtest/gtest.h>

#include <random>

namespace facetloc::internal {
namespace {

void inOrder(std::size_t n, const std::function<void(std::size_t)>& job) {
  for (std::size_t i = 0; i < n; ++i) job(i);
}

PlaceRules robot() {
  PlaceRules rules;
  rules.heights = {0.95};
  rules.stands = true;
  return rules;
}

bool inFirst(const Eigen::Vector3d& p) { return p.x() > 0 && p.x() < 6 && p.y() > 0 && p.y() < 4; }
bool inSecond(const Eigen::Vector3d& p) { return p.x() > 6.2 && p.x() < 10.2 && p.y() > 0 && p.y() < 4; }

TEST(FreePlaces, FillsRoomsAndNothingElse) {
  for (const bool ceiling : {true, false}) {
    const MeshSurface surface(twoRooms(ceiling).mesh());
    const SpaceProbe probe(surface, Eigen::Isometry3d::Identity());
    int first = 0, second = 0;
    for (const Eigen::Vector3d& p : freePlaces(probe, robot(), inOrder).positions) {
      EXPECT_NEAR(0.95, p.z(), 1e-3);
      first += inFirst(p), second += inSecond(p);
      const bool in_door = p.x() > 5.9 && p.x() < 6.3 && p.y() > 1.5 && p.y() < 2.5;
      EXPECT_TRUE(inFirst(p) || inSecond(p) || in_door) << p.transpose();
      // Not on the table, and not in or on the cabinets.
      EXPECT_FALSE(p.x() > 1 && p.x() < 2.6 && p.y() > 0.6 && p.y() < 1.4) << p.transpose();
      EXPECT_FALSE(p.x() > 4 && p.x() < 5 && p.y() > 3.4) << p.transpose();
      EXPECT_FALSE(p.x() > 9 && p.y() < 0.5) << p.transpose();
    }
    EXPECT_GT(first, 60);  // 96 places on 24 m^2 at most
    EXPECT_GT(second, 40);
  }
}

TEST(FreePlaces, ManyAreEstimated) {
  const MeshSurface hall(BoxMesh().add({0, 0, 0}, {110, 110, 3}).mesh());
  PlaceRules rules = robot();
  rules.most = 1000;
  int looks = 0;
  const FreePlaces found = freePlaces(SpaceProbe(hall, Eigen::Isometry3d::Identity()), rules,
                                      [&](std::size_t n, const std::function<void(std::size_t)>& job) {
                                        inOrder(n, job);
                                        ++looks;
                                      });
  EXPECT_TRUE(found.positions.empty());
  EXPECT_GT(found.too_many, 40000u);  // 48400 places in it, and 48400 on its roof
  EXPECT_LT(found.too_many, 97000u);
  EXPECT_EQ(looks, 2) << "columns and a sample";
}

TEST(FreePlaces, OfAHandAreAboveTables) {
  const MeshSurface surface(twoRooms().mesh());
  PlaceRules hand;
  hand.heights = {1.1, 1.6};
  int above_table = 0;
  const SpaceProbe probe(surface, Eigen::Isometry3d::Identity());
  for (const Eigen::Vector3d& p : freePlaces(probe, hand, inOrder).positions)
    above_table += p.x() > 1 && p.x() < 2.6 && p.y() > 0.6 && p.y() < 1.4;
  EXPECT_GT(above_table, 0);
}

TEST(FreePlaces, FollowTheUpwardDirection) {
  BoxMesh on_side;  // one room, whose x axis is up
  on_side.add({-0.2f, 0, 0}, {0, 6, 4}).add({2.5f, 0, 0}, {2.7f, 6, 4}).add({0, -0.2f, 0}, {2.5f, 0, 4});
  on_side.add({0, 6, 0}, {2.5f, 6.2f, 4}).add({0, 0, -0.2f}, {2.5f, 6, 0}).add({0, 0, 4}, {2.5f, 6, 4.2f});
  const MeshSurface surface(on_side.mesh());
  const Eigen::Isometry3d T_w_up(rotationBetween(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX()));
  const auto places = freePlaces(SpaceProbe(surface, T_w_up), robot(), inOrder).positions;
  EXPECT_GT(places.size(), 60u);
  for (const Eigen::Vector3d& p : places) EXPECT_NEAR(0.95, (T_w_up * p).x(), 1e-3);
}

/** The rooms in a hall, as simulated buildings stand in one. */
BoxMesh hall() {
  BoxMesh mesh = twoRooms();
  mesh.add({-4, -4, -0.2f}, {14, 8, 0}).add({-4, -4, 2.7f}, {14, 8, 2.9f});
  mesh.add({-4, -4, 0}, {14, -3.8f, 2.7f}).add({-4, 7.8f, 0}, {14, 8, 2.7f});
  mesh.add({-4, -4, 0}, {-3.8f, 8, 2.7f}).add({13.8f, -4, 0}, {14, 8, 2.7f});
  return mesh;
}

TEST(FreePlaces, AreNotAroundAllOthersUnlessThatIsAskedFor) {
  const MeshSurface surface(hall().mesh());
  const SpaceProbe probe(surface, Eigen::Isometry3d::Identity());
  const FreePlaces found = freePlaces(probe, robot(), inOrder);
  EXPECT_GT(found.outdoors, 100u);
  EXPECT_GT(found.positions.size(), 100u);
  for (const Eigen::Vector3d& p : found.positions)
    EXPECT_TRUE(p.x() > 0 && p.x() < 10.2 && p.y() > 0 && p.y() < 4) << p.transpose();
  PlaceRules outside = robot();
  outside.inside = {{-2, -2, 0}};
  const FreePlaces around = freePlaces(probe, outside, inOrder);
  EXPECT_GT(around.positions.size(), 100u);
  for (const Eigen::Vector3d& p : around.positions)
    EXPECT_FALSE(p.x() > 0 && p.x() < 10.2 && p.y() > 0 && p.y() < 4) << p.transpose();
}

TEST(FreePlaces, AreMissingInEmptySpaceAndInFrontOfAWall) {
  const MeshSurface wall(BoxMesh().add({0, 0, 0}, {5, 0.2f, 2.5f}).mesh());
  EXPECT_TRUE(
      freePlaces(SpaceProbe(wall, Eigen::Isometry3d::Identity()), robot(), inOrder).positions.empty());
}

TEST(FloorLevels, AreThoseOfStoreysNotOfFurniture) {
  std::vector<std::vector<double>> columns;
  for (int i = 0; i < 100; ++i) {
    const double noise = 0.01 * (i % 3);
    if (i % 3 == 0)  // a table on the ground floor, more often than not
      columns.push_back({5.4, 2.8 + noise, 2.5, 0.75, 0.7, noise});
    else
      columns.push_back({5.4, 2.8 + noise, 2.5, noise});
  }
  const std::vector<double> levels = floorLevels(columns, 1.5);
  ASSERT_EQ(3u, levels.size());  // and the roof
  EXPECT_NEAR(0.01, levels[0], 0.01);
  EXPECT_NEAR(2.81, levels[1], 0.01);
  EXPECT_NEAR(5.4, levels[2], 1e-9);
}

bool covers(const Substitutes& substitutes, const std::vector<std::size_t>& chosen, double shared) {
  std::vector<bool> covered(substitutes.of.size());
  for (const std::size_t i : chosen) {
    covered[i] = true;
    for (const Substitutes::Entry& e : substitutes.of[i])
      if (e.shared >= shared) covered[e.view] = true;
  }
  return std::count(covered.begin(), covered.end(), false) == 0;
}

/** Size of the smallest cover, by trying all. */
std::size_t least(const Substitutes& substitutes, double shared) {
  const std::size_t n = substitutes.of.size();
  std::size_t best = n;
  for (unsigned set = 0; set < 1u << n; ++set) {
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < n; ++i)
      if (set >> i & 1) chosen.push_back(i);
    if (chosen.size() < best && covers(substitutes, chosen, shared)) best = chosen.size();
  }
  return best;
}

TEST(CoveringViews, CoverAllWithFew) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> share(0, 1);
  int chosen_in_all = 0, least_in_all = 0;
  for (int run = 0; run < 50; ++run) {
    Substitutes substitutes;
    substitutes.of.resize(10);
    for (std::uint32_t i = 0; i < 10; ++i)
      for (std::uint32_t j = 0; j < 10; ++j)
        if (i != j && share(random) < 0.3f) substitutes.of[i].push_back({j, share(random)});
    const auto chosen = coveringViews(substitutes, 0.4);
    EXPECT_TRUE(covers(substitutes, chosen, 0.4));
    EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
    chosen_in_all += static_cast<int>(chosen.size());
    least_in_all += static_cast<int>(least(substitutes, 0.4));
  }
  EXPECT_LT(chosen_in_all, 1.15 * least_in_all);
}

TEST(SharedPart, IsTheShareOfThePixelsThatBothSee) {
  // Cameras that look at a wall at a depth of 2 m, the second one to the right by half of the width of an
  // image there.
  const Intrinsics camera{40, 30, 40, 40, 19.5, 14.5};
  const auto seen = [&](double x, double z) {
    SmallView view{Eigen::Isometry3d::Identity(), std::vector<float>(40 * 30, 2.0f - static_cast<float>(z))};
    view.T_w_c.translation() << x, 0, z;
    return view;
  };
  EXPECT_DOUBLE_EQ(1, sharedPart(seen(0, 0), seen(0, 0), camera));
  EXPECT_NEAR(0.5, sharedPart(seen(0, 0), seen(1, 0), camera), 0.05);
  EXPECT_NEAR(0.25, sharedPart(seen(0, 0), seen(0, 1), camera), 0.05);  // seen at half the distance
  EXPECT_NEAR(1, sharedPart(seen(0, 1), seen(0, 0), camera), 0.05);
  SmallView hidden = seen(0, 0);
  hidden.depth.assign(hidden.depth.size(), 1.0f);  // something stands in front of the wall
  EXPECT_DOUBLE_EQ(0, sharedPart(seen(0, 0), hidden, camera));
  SmallView unknown = seen(0, 0);
  unknown.depth.assign(unknown.depth.size(), 0.0f);
  EXPECT_DOUBLE_EQ(0, sharedPart(seen(0, 0), unknown, camera));
  EXPECT_DOUBLE_EQ(0, sharedPart(unknown, seen(0, 0), camera));
}

}  // namespace
}  // namespace facetloc::internal
