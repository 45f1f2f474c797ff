// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/map_review.h"
#include "sessions/session_place.h"

#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace facetloc {

using namespace internal;

namespace {

using test::lookingAlong, test::PoseNear, test::viewFrom;

const test::Scene kChest = test::box({2.6, 2.2, 0}, {3.4, 2.8, 0.9});
const Eigen::Vector3d kMiddle(3, 2.5, 0.6);

/** Round the middle of the room, looking across it. */
Eigen::Isometry3d lookAt(double angle_deg, double radius = 1.8) {
  const double a = angle_deg * kDegree;
  const Eigen::Vector3d from = kMiddle + Eigen::Vector3d(radius * std::cos(a), radius * std::sin(a), 0.6);
  return lookingAlong(from, kMiddle - from);
}

class ASessionInARoom : public testing::Test {
protected:
  static constexpr int kModels = 12;

  /** A map of the room with the chest in its middle. */
  static Map mapOfRoom() {
    Map map;
    for (int i = 0; i < kModels; ++i) {
      const Eigen::Isometry3d T = lookAt(30. * i);
      map.models.emplace_back("m" + std::to_string(i), double(i), T,
                              viewFrom(test::largeRoom() + kChest, T, static_cast<unsigned>(i)));
      if (i > 0) map.links.push_back(MapBuilder().link(i - 1, i, *map.models[i - 1].T_w_m, T));
    }
    return map;
  }
  static std::vector<SessionImage> sessionOf(const test::Scene& scene) {
    std::vector<SessionImage> session;
    for (int i = 0; i < 36; ++i) {
      const Eigen::Isometry3d T = lookAt(10. * i + 4, 1.7);
      session.push_back({"s" + std::to_string(i), 100. + i,
                         std::make_shared<const View>(viewFrom(scene, T, static_cast<unsigned>(50 + i))), T});
    }
    return session;
  }
  static MapChanges updated(Map& map, const std::vector<SessionImage>& session, int threads = 1) {
    return updateMap(map, session, MapReview(map, session, threads));
  }
  static CameraTrajectory trajectoryOf(const std::vector<SessionImage>& session,
                                       const Eigen::Isometry3d& T_s_w) {
    CameraTrajectory out;
    for (std::size_t i = 0; i < session.size(); i += 3) {
      const auto k = static_cast<int>(out.keyframes.size());
      out.keyframes.push_back({i, session[i].view, {T_s_w * session[i].T_w_c, Matrix6d::Zero()}, 0});
      if (k > 0) {
        const Eigen::Isometry3d T = out.keyframes[k - 1].T_w_c.T.inverse() * out.keyframes[k].T_w_c.T;
        Matrix6d P = Matrix6d::Identity() * 1e-4;
        out.motions.push_back({k - 1, k, {T, P}, KeyframeMotion::Source::odometry});
      }
    }
    return out;
  }
};

TEST_F(ASessionInARoom, IsFoundWhereItIs) {
  const auto map = std::make_shared<const Map>(mapOfRoom());
  const GlobalLocalization localization(map);
  const std::vector<SessionImage> session = sessionOf(test::largeRoom() + kChest);
  Eigen::Isometry3d T_s_w = lookAt(77, 20);
  const CameraTrajectory trajectory = trajectoryOf(session, T_s_w);
  const SessionPlace bent = placeInMap(localization, trajectory, {});
  const SessionPlace rigid = placeRigidly(localization, trajectory, {}, {});
  ASSERT_TRUE(bent.found());
  ASSERT_TRUE(rigid.found());
  EXPECT_GE(bent.agreeing, 6u);
  EXPECT_EQ(std::count(rigid.confirmed.begin(), rigid.confirmed.end(), true),
            std::ptrdiff_t(trajectory.keyframes.size()));
  EXPECT_GE(std::count(bent.confirmed.begin(), bent.confirmed.end(), true), std::ptrdiff_t(bent.agreeing));
  for (std::size_t k = 0; k < trajectory.keyframes.size(); ++k) {
    ASSERT_TRUE(bent.T_w_k[k] && rigid.T_w_k[k]);
    EXPECT_THAT(*bent.T_w_k[k], PoseNear(session[3 * k].T_w_c, 0.02, 1)) << k;
    EXPECT_THAT(*rigid.T_w_k[k], PoseNear(session[3 * k].T_w_c, 0.02, 1)) << k;
  }
}

TEST_F(ASessionInARoom, IsNotFoundInAMapOfAnotherPlace) {
  const auto map = std::make_shared<const Map>(mapOfRoom());
  const GlobalLocalization localization(map);
  const test::Scene elsewhere = test::box({-1, -1, 0}, {9, 8, 3.4}) + test::box({1, 1, 0}, {1.6, 3, 2.2});
  const std::vector<SessionImage> session = sessionOf(elsewhere);
  const SessionPlace place = placeInMap(localization, trajectoryOf(session, lookAt(0, 20)), {});
  EXPECT_FALSE(place.found());
  EXPECT_EQ(place.asked, 12u);
}

TEST_F(ASessionInARoom, ChangesNothingWhereNothingHasChanged) {
  Map map = mapOfRoom();
  const MapChanges changes = updated(map, sessionOf(test::largeRoom() + kChest));
  EXPECT_TRUE(changes.edited.empty());
  EXPECT_TRUE(changes.retired.empty());
  EXPECT_EQ(changes.surfaces, 0u);
  EXPECT_EQ(changes.seen, std::size_t(kModels));
  EXPECT_LE(map.models.size(), 1.3 * kModels);
}

TEST_F(ASessionInARoom, RemovesGoneSurfaces) {
  Map map = mapOfRoom();
  const std::vector<SessionImage> session = sessionOf(test::largeRoom());
  const MapChanges changes = updated(map, session, 2);
  EXPECT_GE(changes.surfaces, std::size_t(kModels));
  EXPECT_TRUE(changes.any());
  const auto isOfChest = [](const Segment& s, const Eigen::Isometry3d& T_w_m) {
    const Eigen::Vector3d p = T_w_m * s.t;
    return (p - kMiddle).head<2>().cwiseAbs().maxCoeff() < 0.45 && p.z() > 0.05;
  };
  int left = 0;
  for (int i = 0; i < static_cast<int>(map.models.size()); ++i)
    for (const Segment& s : map.view(i)->segments) left += isOfChest(s, *map.models[i].T_w_m);
  EXPECT_LE(left, 1);
  // The same session again finds nothing to do.
  const std::size_t models = map.models.size();
  const MapChanges again = updated(map, session);
  EXPECT_EQ(map.models.size(), models);
  EXPECT_TRUE(again.added.empty());
  EXPECT_TRUE(again.replaced.empty());
}

TEST_F(ASessionInARoom, RenewsWhereSomethingHasCome) {
  const test::Scene table = test::box({2.55, 2.15, 0}, {3.45, 2.85, 0.9});
  Map map;
  for (const SessionImage& image : sessionOf(test::largeRoom()))
    if (map.models.size() < kModels)
      map.models.emplace_back("m" + image.name, image.stamp, image.T_w_c, *image.view);
  const std::size_t before = map.models.size();
  const std::vector<SessionImage> with_table = sessionOf(test::largeRoom() + table);
  std::vector<SessionImage> once = sessionOf(test::largeRoom());
  once[4] = with_table[4];  // somebody who has gone by the next image
  Map map_after_once = map;
  EXPECT_TRUE(updated(map_after_once, once).replaced.empty());

  const MapChanges changes = updated(map, with_table);
  EXPECT_GE(changes.replaced.size(), 6u);
  EXPECT_EQ(map.models.size(), before + changes.added.size());
}

/** The area of changes of one kind, and how much of it is on the chest. */
std::pair<double, double> areasOf(const std::vector<SurfaceChange>& changes, SurfaceChange::Kind kind) {
  double all = 0, of_chest = 0;
  const Eigen::AlignedBox3d chest(Eigen::Vector3d(2.55, 2.15, -0.05), Eigen::Vector3d(3.45, 2.85, 0.95));
  for (const SurfaceChange& c : changes) {
    if (c.kind != kind) continue;
    all += c.area;
    of_chest += chest.contains(c.centre) ? c.area : 0;
    EXPECT_GE(c.probability, 0.5);
    EXPECT_LE(c.probability, 1);
    EXPECT_GE(c.looks, 2u);
    EXPECT_GE(c.outline.size(), 3u);
  }
  return {all, of_chest};
}

TEST_F(ASessionInARoom, TellsTheSurfacesThatHaveGoneOrCome) {
  constexpr double kOfChest = 2 * 0.9 * (0.8 + 0.6) + 0.8 * 0.6;  // its sides and its top [m^2]
  const Map with_chest = mapOfRoom();
  const std::vector<SessionImage> empty = sessionOf(test::largeRoom());
  const auto gone = MapReview(with_chest, empty).changes();
  EXPECT_EQ(gone.size(), MapReview(with_chest, empty, 2).changes().size());
  const auto [removed, of_chest] = areasOf(gone, SurfaceChange::Kind::removed);
  EXPECT_GT(of_chest, 0.8 * kOfChest);
  EXPECT_LT(of_chest, 1.1 * kOfChest);
  EXPECT_GT(of_chest, 0.95 * removed);
  EXPECT_LT(areasOf(gone, SurfaceChange::Kind::added).first, 0.05);

  Map without;
  for (const SessionImage& image : empty)
    without.models.emplace_back(image.name, image.stamp, image.T_w_c, *image.view);
  std::vector<SessionImage> later = sessionOf(test::largeRoom() + kChest);
  const auto come = MapReview(without, later).changes();
  const auto [added, on_chest] = areasOf(come, SurfaceChange::Kind::added);
  EXPECT_GT(on_chest, 0.8 * kOfChest);
  EXPECT_LT(on_chest, 1.1 * kOfChest);
  EXPECT_GT(on_chest, 0.95 * added);
  EXPECT_LT(areasOf(come, SurfaceChange::Kind::removed).first, 0.05);

  std::vector<SessionImage> once = empty;
  once[4] = later[4];  // somebody who has gone by the next image
  EXPECT_TRUE(MapReview(without, once).changes().empty());
}

TEST_F(ASessionInARoom, AddsPlacesThatTheMapDoesNotShow) {
  Map map = mapOfRoom();
  map.models.resize(3);
  map.links.clear();
  const std::size_t before = map.models.size();
  const MapChanges changes = updated(map, sessionOf(test::largeRoom() + kChest));
  EXPECT_GE(changes.added.size(), 4u);
  ASSERT_EQ(map.models.size(), before + changes.added.size());
  EXPECT_FALSE(map.links.empty());
  for (const Link& link : map.links) {
    EXPECT_LT(link.from, link.to);
    EXPECT_LT(link.to, static_cast<int>(map.models.size()));
  }
}

TEST(MapSessionNotes, AreNumberedAfterTheFirstSessionOfTheMap) {
  MapChanges changes;
  changes.added = {"a"};
  changes.edited = {"b", "c"};
  EXPECT_EQ("1 local model added, 0 replaced, 0 retired, 2 without moved surfaces", changes.toString());
  Map map;
  map.meta["session 3"] = "of another tool";
  for (const char* words : {"monday", "tuesday"}) noteSession(words, map);
  EXPECT_EQ("monday", map.meta.at("session 2"));
  EXPECT_EQ("of another tool", map.meta.at("session 3"));
  EXPECT_EQ("tuesday", map.meta.at("session 4"));
}

}  // namespace
}  // namespace facetloc
