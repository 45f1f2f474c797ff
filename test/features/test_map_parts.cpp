// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/map_parts.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <gmock/gmock.h>

#include <limits>

namespace facetloc {
namespace {

using test::PoseNear, test::randomPose, test::Rng, test::uniform, testing::ElementsAre, testing::IsEmpty;

Map mapOfModels(int n) {
  Map map;
  map.models.resize(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) map.models[i].name = std::string(1, static_cast<char>('a' + i));
  return map;
}

Link linkOf(int from, int to, const Eigen::Isometry3d& T_from_to, double std = 0.01) {
  Link link;
  link.from = from, link.to = to;
  link.T_from_to.T = T_from_to;
  link.T_from_to.P = std * std * Matrix6d::Identity();
  return link;
}

/** A link that lies as the true poses do. */
Link trueLink(const std::vector<Eigen::Isometry3d>& poses, int from, int to) {
  return linkOf(from, to, poses[from].inverse() * poses[to]);
}

std::vector<Eigen::Isometry3d> randomPoses(Rng& rng, int n) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < n; ++i) poses.push_back(randomPose(rng, 3, 5));
  return poses;
}

struct Path {
  double cost = std::numeric_limits<double>::infinity();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();  // pose of its end
};

/** Follows every path without loops that leads from a model to another one. */
void follow(const Map& map, int at, int to, const Path& so_far, std::vector<char>& visited, Path& best) {
  if (at == to && so_far.cost < best.cost) best = so_far;
  visited[at] = 1;
  for (const Link& link : map.links)
    for (const bool forward : {true, false}) {
      const int from = forward ? link.from : link.to, next = forward ? link.to : link.from;
      if (from != at || visited[next]) continue;
      const Eigen::Isometry3d T = forward ? link.T_from_to.T : link.T_from_to.T.inverse();
      follow(map, next, to, {so_far.cost + uncertaintyOf(link), so_far.T * T}, visited, best);
    }
  visited[at] = 0;
}

TEST(MapParts, PosesAreThoseOfTheBestOfAllPaths) {
  constexpr int kModels = 7, kLinks = 11;
  Rng rng(3);
  int placed = 0;
  for (int repetition = 0; repetition < 30; ++repetition) {
    Map map = mapOfModels(kModels);
    for (int i = 0; i < kLinks; ++i) {
      const int from = static_cast<int>(uniform(rng, 0, kModels - 0.01));
      const int to = (from + 1 + static_cast<int>(uniform(rng, 0, kModels - 1.01))) % kModels;
      map.links.push_back(linkOf(from, to, randomPose(rng, 3, 2), uniform(rng, 0.01, 0.1)));  // all disagree
    }
    for (int i = 0; i <= repetition % 3; ++i) map.models[2 * i].T_w_m = randomPose(rng, 3, 5);
    const Map given = map;
    placeByLinks(map);
    for (int i = 0; i < kModels; ++i) {
      ASSERT_TRUE(map.models[i].T_w_m);
      Path best;
      for (int source = 0; source < kModels; ++source) {
        if (!given.models[source].T_w_m) continue;
        std::vector<char> visited(kModels, 0);
        follow(map, source, i, {0, *given.models[source].T_w_m}, visited, best);
      }
      EXPECT_EQ(std::isfinite(best.cost), map.models[i].part == 0);
      EXPECT_EQ(map.models[i].by_links, !given.models[i].T_w_m);
      if (!std::isfinite(best.cost)) continue;
      EXPECT_THAT(*map.models[i].T_w_m, PoseNear(best.T, 1e-9, 1e-6));
      placed += map.models[i].by_links;
    }
  }
  EXPECT_GT(placed, 60);
}

TEST(MapParts, ConnectedModelsAreOneWorld) {
  Rng rng(4);
  const auto poses = randomPoses(rng, 4);
  Map map = mapOfModels(4);
  map.links = {trueLink(poses, 2, 0), trueLink(poses, 2, 1), trueLink(poses, 1, 3)};
  placeByLinks(map);
  EXPECT_THAT(map.parts, ElementsAre(""));
  EXPECT_FALSE(hasGivenPose(map));
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(map.models[i].part, 0);
    EXPECT_TRUE(map.models[i].by_links);
    EXPECT_FALSE(map.models[i].givenPose());
    EXPECT_THAT(*map.models[i].T_w_m, PoseNear(poses[0].inverse() * poses[i], 1e-9, 1e-6));
  }
}

TEST(MapParts, UnconnectedModelsAreInNamedParts) {
  Rng rng(5);
  const auto poses = randomPoses(rng, 6);
  Map map = mapOfModels(6);
  map.links = {trueLink(poses, 4, 1), trueLink(poses, 1, 3), trueLink(poses, 5, 0)};
  map.camera.mounting = CameraMounting{1.1, 12};
  placeByLinks(map);
  EXPECT_THAT(map.parts, ElementsAre("a", "b", "c"));
  std::vector<int> parts;
  for (const LocalModel& model : map.models) parts.push_back(model.part);
  EXPECT_THAT(parts, ElementsAre(0, 1, 2, 1, 1, 0));
  EXPECT_EQ(map.partOf(3), "b");
  EXPECT_EQ(partCounts(map)[1].models, 3u);
  EXPECT_EQ(mainPart(map), 1);
  const Eigen::Isometry3d upright = map.camera.mounting->T_b_c();
  for (const int first : {0, 1, 2}) EXPECT_THAT(*map.models[first].T_w_m, PoseNear(upright, 0, 1e-9));
  EXPECT_THAT(*map.models[4].T_w_m, PoseNear(upright * poses[1].inverse() * poses[4], 1e-9, 1e-6));
}

TEST(MapParts, GivenPosesStayAndAreTheWorld) {
  Rng rng(6);
  const auto poses = randomPoses(rng, 6);
  Map map = mapOfModels(6);
  map.models[2].T_w_m = poses[2];
  map.models[5].T_w_m = poses[5];  // alone
  map.links = {trueLink(poses, 0, 1), trueLink(poses, 3, 2), trueLink(poses, 3, 4)};
  placeByLinks(map);
  EXPECT_THAT(map.parts, ElementsAre("", "a"));
  EXPECT_TRUE(hasGivenPose(map));
  EXPECT_EQ(mainPart(map), 0);
  for (const int i : {2, 3, 4, 5}) {
    EXPECT_EQ(map.partOf(i), "");
    EXPECT_THAT(*map.models[i].T_w_m, PoseNear(poses[i], 1e-9, 1e-6));
    EXPECT_EQ(map.models[i].by_links, i == 3 || i == 4);
  }
  EXPECT_EQ(partCounts(map)[0].models, 4u);
  EXPECT_EQ(partCounts(map)[0].by_links, 2u);
  EXPECT_EQ(map.partOf(1), "a");

  map.links.push_back(trueLink(poses, 5, 1));  // which joins everything
  placeByLinks(map);
  EXPECT_THAT(map.parts, ElementsAre(""));
  for (int i = 0; i < 6; ++i) EXPECT_THAT(*map.models[i].T_w_m, PoseNear(poses[i], 1e-9, 1e-6));
}

TEST(MapParts, InvalidLinksDoNotCount) {
  Map map = mapOfModels(3);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d nowhere = T;
  nowhere.translation().x() = kNan;
  map.links = {linkOf(0, 7, T), linkOf(-1, 0, T), linkOf(0, 1, nowhere), linkOf(1, 2, T, kNan),
               linkOf(2, 2, T)};
  placeByLinks(map);
  EXPECT_EQ(map.parts.size(), 3u);
  for (const LocalModel& model : map.models) EXPECT_TRUE(model.T_w_m->matrix().allFinite());
  Map empty;
  placeByLinks(empty);
  EXPECT_THAT(empty.parts, IsEmpty());
  EXPECT_EQ(mainPart(empty), 0);
}

TEST(MapParts, AMapThatWasNotPlacedIsOneWorld) {
  Map map = mapOfModels(2);
  EXPECT_EQ(map.partOf(1), "");
  ASSERT_EQ(partCounts(map).size(), 1u);
  EXPECT_EQ(partCounts(map)[0].models, 2u);
  EXPECT_EQ(partCounts(map)[0].by_links, 0u);
}

TEST(MapParts, AWorldOfAHundredThousandModelsIsPlacedAtOnce) {
  constexpr int kModels = 100000;
  Map map;
  map.models.resize(kModels);
  Rng rng(7);
  const Eigen::Isometry3d step = randomPose(rng, 0.2, 0.5);
  for (int i = 0; i + 1 < kModels; ++i) map.links.push_back(linkOf(i, i + 1, step));
  placeByLinks(map);
  EXPECT_EQ(map.parts.size(), 1u);
  EXPECT_THAT(map.models.back().T_w_m->linear().eval(), test::IsRotation());
}

}  // namespace
}  // namespace facetloc
