// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/localization/place_index.h>
#include <facetloc/mapping/growing_map.h>
#include <facetloc/mapping/map_making.h>
#include <facetloc/mapping/map_session.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gmock/gmock.h>

#include <atomic>
#include <set>
#include <stdexcept>
#include <vector>

namespace facetloc {
namespace {

using test::lookingAlong, test::PoseNear, testing::HasSubstr, testing::IsEmpty;

/** On a circle about the middle of the large room, looking across it. */
Eigen::Isometry3d onCircle(double degrees) {
  const double a = degrees * kDegree;
  const Eigen::Vector3d out(std::cos(a), std::sin(a), 0);
  return lookingAlong(Eigen::Vector3d(3, 2.5, 1.2) + 1.8 * out, Eigen::Vector3d(-out.x(), -out.y(), -0.35));
}

MapImage imageOf(int number, double degrees, bool with_pose) {
  const Eigen::Isometry3d T_w_c = onCircle(degrees);
  MapImage image;
  image.name = "image" + std::to_string(number);
  image.stamp = 0.2 * number;
  image.load = [T_w_c, number] {
    return test::noisy(test::render(test::largeRoom(), test::smallCamera(), T_w_c).image,
                       SensorNoise{}.inverse_depth_std, static_cast<unsigned>(number));
  };
  if (with_pose) image.T_w_c = T_w_c;
  return image;
}

constexpr int kImages = 24;
constexpr double kStep = 3;   // [deg]
constexpr int kPerModel = 5;  // images in 15 deg

MapMaking making(bool with_poses, const MapMakingParams& params = {}) {
  MapMaking making({}, params);
  for (int i = 0; i < kImages; ++i) making.add(imageOf(i, kStep * i, with_poses));
  return making;
}

TEST(MapMaking, MakesAMapAlongPoses) {
  MapMaking along = making(true);
  const Map map = along.finish();
  ASSERT_EQ(map.models.size(), 5u);
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const int number = kPerModel * static_cast<int>(i);
    EXPECT_EQ(map.models[i].name, "image" + std::to_string(number));
    EXPECT_THAT(*map.models[i].T_w_m, PoseNear(onCircle(kStep * number), 1e-9, 1e-9));
    EXPECT_FALSE(map.view(static_cast<int>(i))->camera) << "the map's";
  }
  ASSERT_EQ(map.links.size(), 4u);
  EXPECT_EQ(map.links[3].to, 4);
  const MapFindings& found = along.findings();
  ASSERT_TRUE(found.poses && found.poses->isKnown());
  EXPECT_LT(found.poses->as_given.translation, 0.02);
  EXPECT_EQ(found.poses->cause, "");
  EXPECT_FALSE(found.trajectory);
  EXPECT_THAT(found.unread, IsEmpty());
  EXPECT_EQ(found.problem, "");
}

TEST(MapMaking, FindsTheTrajectoryWherePosesLack) {
  MapMaking by_images = making(false);
  const Map map = by_images.finish();
  ASSERT_TRUE(by_images.findings().trajectory);
  EXPECT_EQ(by_images.findings().trajectory->images.size(), std::size_t(kImages));
  ASSERT_GE(map.models.size(), 4u);
  EXPECT_GE(map.links.size(), map.models.size() - 1);
  const Eigen::Isometry3d T_true_w = onCircle(0) * map.models.front().T_w_m->inverse();
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const int number = std::stoi(map.models[i].name.substr(5));
    EXPECT_THAT(T_true_w * *map.models[i].T_w_m, PoseNear(onCircle(kStep * number), 0.03, 1)) << number;
  }
}

TEST(MapMaking, IsTheSameForAnyNumberOfThreads) {
  MapMaking one = making(false), many = making(false);
  many.setNumberOfThreads(3);
  const Map a = one.finish(), b = many.finish();
  ASSERT_EQ(a.models.size(), b.models.size());
  for (std::size_t i = 0; i < a.models.size(); ++i) {
    EXPECT_EQ(a.models[i].T_w_m->matrix(), b.models[i].T_w_m->matrix()) << i;
    EXPECT_EQ(a.models[i].alias_score, b.models[i].alias_score) << i;
  }
}

TEST(MapMaking, ReadsFewImagesTwice) {
  constexpr int kModels = 5;
  for (const bool with_poses : {true, false}) {
    std::atomic<int> reads{0};
    MapMaking counted;
    for (int i = 0; i < kImages; ++i) {
      MapImage image = imageOf(i, kStep * i, with_poses);
      image.load = [&reads, load = image.load] { return ++reads, load(); };
      counted.add(image);
    }
    counted.setNumberOfThreads(2);
    ASSERT_FALSE(counted.finish().models.empty());
    if (with_poses)
      EXPECT_EQ(reads, kImages + kModels);
    else
      EXPECT_LE(reads, 3 * kImages + 2 * kModels) << "before and after the distortion is known";
  }
}

TEST(MapMaking, LeavesOutImagesThatCannotBeRead) {
  MapMaking some = making(true);
  MapImage broken = imageOf(kImages, kStep * (kImages + 6), true);
  broken.load = []() -> DepthImage { throw std::runtime_error("torn.png: is torn"); };
  some.add(broken);
  MapImage black = imageOf(kImages + 1, kStep * (kImages + 12), true);
  black.load = [] { return DepthImage(); };
  some.add(black);
  EXPECT_EQ(some.finish().models.size(), 5u);
  ASSERT_EQ(some.findings().unread.size(), 1u);
  EXPECT_EQ(some.findings().unread.front().image, std::size_t(kImages));
  EXPECT_EQ(some.findings().unread.front().cause, "torn.png: is torn");
  EXPECT_EQ(some.findings().without_segments, 1u);
}

TEST(MapMaking, NamesTheProblemWhereThereIsNoMap) {
  MapMaking empty;
  EXPECT_THAT(empty.finish().models, IsEmpty());
  EXPECT_EQ(empty.findings().problem, "there are no images");
  MapMaking torn;
  for (int i = 0; i < 3; ++i)
    torn.add(
        {"image" + std::to_string(i), 0.1 * i, []() -> DepthImage { throw std::runtime_error("torn"); }});
  EXPECT_THAT(torn.finish().models, IsEmpty());
  EXPECT_EQ(torn.findings().problem, "no image can be read: torn");
  MapMaking black;
  for (int i = 0; i < 3; ++i)
    black.add({std::to_string(i), 0.1 * i, [] { return DepthImage(); }, onCircle(40 * i)});
  EXPECT_THAT(black.finish().models, IsEmpty());
  EXPECT_EQ(black.findings().problem, "none of the images makes a local model");
}

/** Images with poses that some of them have otherwise. */
MapMaking makingWith(const std::function<Eigen::Isometry3d(int number)>& pose) {
  MapMakingParams params;
  params.any_reading = true;
  MapMaking making({}, params);
  for (int i = 0; i < kImages; ++i) {
    MapImage image = imageOf(i, kStep * i, true);
    image.T_w_c = pose(i);
    making.add(image);
  }
  return making;
}

TEST(MapMaking, PosesThatBeginAnewArePartsOfTheMap) {
  MapMaking anew = makingWith([](int i) {
    return i < kImages / 2 ? onCircle(kStep * i)
                           : onCircle(kStep * kImages / 2).inverse() * onCircle(kStep * i);
  });
  const Map map = anew.finish();
  ASSERT_EQ(anew.findings().jumps.size(), 1u);
  EXPECT_EQ(anew.findings().jumps.front().image, std::size_t(kImages / 2));
  ASSERT_EQ(map.parts.size(), 2u);
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const int number = std::stoi(map.models[i].name.substr(5));
    EXPECT_EQ(map.partOf(static_cast<int>(i)).empty(), number < kImages / 2) << number;
    if (number < kImages / 2) {
      EXPECT_THAT(*map.models[i].T_w_m, PoseNear(onCircle(kStep * number), 1e-9, 1e-9)) << number;
    }
  }
  for (const Link& link : map.links) EXPECT_EQ(map.partOf(link.from), map.partOf(link.to));
}

TEST(MapMaking, NoPoseIsTooFastAtAnAssumedRate) {
  for (const bool timed : {true, false}) {
    MapMaking numbered;
    for (int i = 0; i < kImages; ++i) {
      MapImage image = imageOf(i, 2 * kStep * i + (i < kImages / 2 ? 0 : 120), true);  // 3 m in between
      image.timed = timed;
      numbered.add(image);
    }
    numbered.checkPoses();
    EXPECT_EQ(numbered.findings().jumps.size(), timed ? 1u : 0u);
    EXPECT_TRUE(numbered.pose(0));
    EXPECT_EQ(numbered.pose(kImages - 1).has_value(), !timed);
  }
}

TEST(MapMaking, ASingleFarPoseDividesNothing) {
  MapMaking one = makingWith(
      [](int i) { return i == 10 ? Eigen::Isometry3d(Eigen::Translation3d(0, 0, 5)) : onCircle(kStep * i); });
  one.checkPoses();
  EXPECT_EQ(one.findings().jumps.size(), 2u);
  EXPECT_TRUE(one.pose(9));
  EXPECT_FALSE(one.pose(10));
  EXPECT_TRUE(one.pose(11));
}

TEST(MapMaking, NamesASinglePoseThatIsOff) {
  MapMaking one =
      makingWith([](int i) { return Eigen::Translation3d(0, 0, i == 10 ? 0.6 : 0) * onCircle(kStep * i); });
  one.checkPoses();
  EXPECT_THAT(one.findings().jumps, IsEmpty());
  EXPECT_THAT(one.findings().poses->outliers, testing::Contains(testing::Truly([](const PoseOutlier& o) {
                return std::abs(o.stamp_a - 2) < 1e-9 || std::abs(o.stamp_b - 2) < 1e-9;
              })));
  EXPECT_FALSE(one.findings().poses->hasTail());
}

TEST(MapMaking, RefusesPosesThatTheImagesContradict) {
  const auto inverted = [](bool any_reading) {
    MapMakingParams params;
    params.any_reading = any_reading;
    MapMaking making({}, params);
    for (int i = 0; i < kImages; ++i) {
      MapImage image = imageOf(i, kStep * i, true);
      image.T_w_c = image.T_w_c->inverse();
      making.add(image);
    }
    return making;
  };
  MapMaking refused = inverted(false), forced = inverted(true);
  EXPECT_THAT(refused.finish().models, IsEmpty());
  EXPECT_THAT(refused.findings().problem, HasSubstr("they are inverted"));
  EXPECT_FALSE(forced.finish().models.empty());
  EXPECT_TRUE(forced.findings().poses->wrong_convention);
}

TEST(MapMaking, TakesEachNthImageWhateverItsPose) {
  MapMakingParams params;
  params.every = 10;
  MapMaking each = making(false, params);
  const Map map = each.finish();
  EXPECT_EQ(map.models.size(), 3u);
  EXPECT_FALSE(each.findings().trajectory);
  EXPECT_THAT(map.links, IsEmpty());
  params.every = -1;
  EXPECT_THROW(MapMaking({}, params), std::invalid_argument);
}

TEST(MapMaking, ReportsProgressAndEndsWhenAsked) {
  MapMaking watched = making(true);
  watched.setNumberOfThreads(2);
  std::set<MapProgress::Stage> stages;
  watched.setProgress([&](const MapProgress& at) {
    EXPECT_LE(at.done, at.total);
    stages.insert(at.stage);
  });
  watched.finish();
  using Stage = MapProgress::Stage;
  EXPECT_THAT(stages, testing::UnorderedElementsAre(Stage::poses, Stage::distortion, Stage::models,
                                                    Stage::ambiguity));
  std::atomic<int> calls{0};
  MapMaking stopped = making(true);
  stopped.setProgress([&](const MapProgress&) {
    ++calls;
    throw std::runtime_error("stop");
  });
  EXPECT_THROW(stopped.finish(), std::runtime_error);
  EXPECT_EQ(calls, 1);
}

TEST(MapMaking, LinksOnlyImagesThatThereAre) {
  EXPECT_EQ(making(true).links({0, 3}).size(), 1u);
  EXPECT_THROW(making(true).links({0, kImages}), std::invalid_argument);
}

TEST(MapMaking, AnIndexIsKeptForLargeMapsOfARobot) {
  Map map;
  map.camera.mounting = CameraMounting{1, 10};
  const View view = test::viewFrom(test::largeRoom(), onCircle(0), 1);
  for (int i = 0; i < 400; ++i) map.models.push_back(LocalModel{std::to_string(i), 0, onCircle(i), view});
  EXPECT_FALSE(placeIndexOf(map));
  map.models.push_back(LocalModel{"400", 0, onCircle(0), view});
  EXPECT_TRUE(placeIndexOf(map));
  map.camera.mounting.reset();
  EXPECT_FALSE(placeIndexOf(map));
}

TEST(MapSession, BringsAMapUpToDateWithImages) {
  const auto map = std::make_shared<const Map>(making(true).finish());
  const Eigen::Isometry3d T_s_w = onCircle(123);
  for (const bool with_poses : {true, false}) {
    MapSession session(map, {});
    session.setNumberOfThreads(2);
    for (int i = 0; i < kImages; ++i) {
      MapImage image = imageOf(100 + i, kStep * i + 10, with_poses);
      if (with_poses) image.T_w_c = T_s_w * *image.T_w_c;
      session.add(image);
    }
    ASSERT_TRUE(session.find().found()) << with_poses;
    ASSERT_FALSE(session.poses().empty());
    for (const TrajectoryPose& pose : session.poses()) {
      const double number = pose.stamp / 0.2 - 100;
      EXPECT_THAT(pose.T_w_c, PoseNear(onCircle(kStep * number + 10), 0.05, 1)) << pose.stamp;
    }
    Map changed = *map;
    const MapChanges changes = session.update(changed);
    EXPECT_GT(changes.seen, 0u);
    EXPECT_THAT(changes.retired, IsEmpty());
    EXPECT_EQ(changed.models.size(), map->models.size() + changes.added.size());
  }
}

TEST(GrowingMap, HasEachPlaceOnce) {
  GrowingMap map;
  EXPECT_FALSE(map.latest());
  const auto add = [&](int i) {
    const View view = test::viewFrom(test::largeRoom(), onCircle(kStep * i), static_cast<unsigned>(i));
    return map.add(view, "image" + std::to_string(i), 0.2 * i);
  };
  std::vector<int> numbers;  // numbers of the images that are local models
  for (int i = 0; i < kImages; ++i)
    if (add(i)) numbers.push_back(i);
  const int places = map.size();
  EXPECT_EQ(numbers.size(), std::size_t(places));
  EXPECT_NEAR(places, 5, 1);
  for (int i = kImages - 1; i >= 0; --i) EXPECT_FALSE(add(i)) << "back at " << i;
  ASSERT_TRUE(map.latest());

  ASSERT_TRUE(map.canBeImproved());
  GrowingMap improved = map.clone();
  improved.improve();
  EXPECT_TRUE(map.canBeImproved());
  EXPECT_LT(map.adopt(improved), 0.05);
  EXPECT_FALSE(map.canBeImproved());
  const Eigen::Isometry3d T_true_w = onCircle(0) * map.poses().front()->inverse();
  const auto made = map.map({});
  ASSERT_EQ(made->models.size(), std::size_t(places));
  for (int i = 0; i < places; ++i) {
    EXPECT_THAT(T_true_w * *made->models[i].T_w_m, PoseNear(onCircle(kStep * numbers[i]), 0.03, 1)) << i;
    EXPECT_FALSE(made->view(i)->segments.empty()) << i;
  }
  EXPECT_GE(made->links.size(), std::size_t(places) - 1);
}

}  // namespace
}  // namespace facetloc
