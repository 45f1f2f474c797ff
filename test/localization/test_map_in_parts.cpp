// SPDX-License-Identifier: BSD-3-Clause
// A map that says by its links alone how its places lie to each other is as good as one with poses.
#include "calibration/map_ambiguity.h"
#include "opened_map.h"
#include "ranking/global_localization.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/map_parts.h>
#include <facetloc/localization/localizer.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/testing/pose_matchers.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iomanip>
#include <sstream>
#include <string>

namespace facetloc {

using namespace internal;

namespace {

using test::PoseNear, testing::ElementsAre;

struct Seen {
  View view;
  Eigen::Isometry3d T_w_c;
};

constexpr double kCorrect = 0.2, kCorrectDeg = 3;  // [m, deg]

class MapInParts : public testing::Test {
protected:
  static constexpr std::size_t kFrames = 130, kModels = 40, kQueryStep = 3, kTracked = 60;

  static void SetUpTestSuite() {
    const SimulatedPlace place = simulatedPlace("office", 2);
    DriveParams drive;
    drive.step = 0.25;
    map = std::make_shared<Map>();
    map->camera.mounting = drive.mounting();
    MapBuilder builder;
    for (const Eigen::Isometry3d& T_w_c : simulateDrive(place.mapping_route, kFrames, drive, 5)) {
      if (map->models.size() == kModels || !builder.accept(T_w_c)) continue;
      const int i = static_cast<int>(map->models.size());
      map->models.push_back({"place " + std::to_string(i), 0.1 * i, T_w_c, see(place.mapped, T_w_c)});
      if (i > 0) map->links.push_back(builder.link(i - 1, i, *map->models[i - 1].T_w_m, T_w_c));
    }
    map = test::openedMap(*map);
    drive.sway_deg = 5;
    const auto later = simulateDrive(place.mapping_route, kFrames, drive, 6);
    for (std::size_t i = 0; i < later.size(); i += kQueryStep)
      if (isCovered(later[i])) queries.push_back({see(place.mapped, later[i]), later[i]});
    PaceParams pace;
    pace.rate = 10;
    for (const Eigen::Isometry3d& T_w_c : simulateDrive(place.mapping_route, kTracked, {}, 7, pace))
      drive_on.push_back({see(place.mapped, T_w_c), T_w_c});
  }
  static void TearDownTestSuite() { map.reset(), queries.clear(), drive_on.clear(); }

  static View see(const SimulatedWorld& scene, const Eigen::Isometry3d& T_w_c) {
    static const SimulatedCamera camera(kinectIntrinsics().subsampled(2), SimulatedNoise{}, 3);
    static std::uint64_t frame = 0;
    return ViewBuilder(map->camera).build(camera.render(scene, T_w_c, frame++).depth);
  }
  static bool isCovered(const Eigen::Isometry3d& T_w_c) {
    return std::any_of(map->models.begin(), map->models.end(),
                       [&](const LocalModel& m) { return isNear(*m.T_w_m, T_w_c, 0.5, 15); });
  }
  /** The map without its poses, and without some of its links. */
  static std::shared_ptr<const Map> withoutPoses(const std::vector<int>& cut = {}) {
    auto bare = std::make_shared<Map>(*map);
    for (LocalModel& model : bare->models) model.T_w_m.reset();
    for (auto link = cut.rbegin(); link != cut.rend(); ++link) bare->links.erase(bare->links.begin() + *link);
    placeByLinks(*bare);
    return bare;
  }

  struct Count {
    int sure = 0, wrong = 0;
  };
  /** Counts sure answers; wrong by where they are relative to their local model. */
  static Count countSure(const std::shared_ptr<const Map>& in) {
    const GlobalLocalization localization(in);
    Count count;
    for (const Seen& query : queries) {
      const Localization answer = localization.localize(query.view);
      if (answer.state != AnswerState::sure) continue;
      const Hypothesis& best = answer.hypotheses.front();
      ++count.sure;
      const Eigen::Isometry3d found = *map->models[best.model].T_w_m * best.T_m_c.T;
      count.wrong += !isNear(found, query.T_w_c, kCorrect, kCorrectDeg);
      EXPECT_EQ(best.part, in->models[best.model].part);
      EXPECT_TRUE(best.T_w_c->isApprox(*in->models[best.model].T_w_m * best.T_m_c.T, 1e-9));
      EXPECT_NE(best.evidence, 0);
      for (const int model : best.supporting_models) EXPECT_EQ(in->models[model].part, best.part);
    }
    return count;
  }

  static inline std::shared_ptr<Map> map;
  static inline std::vector<Seen> queries, drive_on;
};

TEST_F(MapInParts, LinksAloneLocalizeAsWellAsPoses) {
  const Count with_poses = countSure(map);
  EXPECT_GT(with_poses.sure, 0.7 * static_cast<double>(queries.size()));
  ASSERT_GT(with_poses.sure, 20);
  const auto bare = withoutPoses();
  EXPECT_THAT(bare->parts, ElementsAre(""));
  const Count by_links = countSure(bare);
  EXPECT_GE(by_links.sure, 0.95 * with_poses.sure);
  EXPECT_EQ(by_links.wrong, 0);
  EXPECT_EQ(with_poses.wrong, 0);
}

// test/aarch64.sh compares the recorded answers of two processors.
TEST_F(MapInParts, AnswersAreRecordedForTheComparisonOfProcessors) {
  const auto record = [](const std::string& name, const Localization& answer) {
    std::ostringstream text;
    text << std::setprecision(12) << toString(answer.state);
    if (!answer.hypotheses.empty()) {
      const Hypothesis& best = answer.hypotheses.front();
      const Eigen::Isometry3d T_w_c = answer.T_w_c ? answer.T_w_c->T : *best.T_w_c;
      text << " " << best.model << " " << std::log(best.probability) - std::log1p(-best.probability) << " "
           << T_w_c.translation().transpose() << " "
           << Eigen::Quaterniond(T_w_c.linear()).coeffs().transpose();
    }
    RecordProperty(name, text.str());
  };
  const GlobalLocalization localization(map);
  int sure = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const Localization answer = localization.localize(queries[i].view);
    sure += answer.state == AnswerState::sure;
    record("single" + std::to_string(i), answer);
  }
  Localizer localizer(map);
  for (std::size_t i = 0; i < drive_on.size(); ++i) {
    const Localization answer = localizer.update(drive_on[i].view, 0.1 * static_cast<double>(i));
    sure += answer.state == AnswerState::sure;
    record("drive" + std::to_string(i), answer);
  }
  EXPECT_GT(sure, static_cast<int>(queries.size() + drive_on.size()) / 2);
}

TEST_F(MapInParts, ViewsInAFileGiveTheAnswersOfThoseInMemory) {
  const auto parts = withoutPoses({13, 26});
  const GlobalLocalization in_file(parts), in_memory(test::inMemory(*parts));
  for (std::size_t i = 0; i < queries.size(); i += 10)
    test::expectSame(in_file.localize(queries[i].view), in_memory.localize(queries[i].view));
}

TEST_F(MapInParts, EachPartIsLocalizedInSeparately) {
  const auto parts = withoutPoses({13, 26});
  EXPECT_THAT(parts->parts, ElementsAre("place 0", "place 14", "place 27"));
  const Count found = countSure(parts);
  EXPECT_GE(found.sure, 0.7 * countSure(map).sure) << "at the borders one place looks like two";
  EXPECT_EQ(found.wrong, 0);
}

TEST_F(MapInParts, AnAmbiguousPartIsAskedForItsOwnPlacesAlone) {
  const auto parts = withoutPoses({13, 26});
  const GlobalLocalization localization(parts);
  for (const int model : {3, 20}) {
    const auto wrong = wrongPlace(localization, model);
    EXPECT_TRUE(!wrong || wrong->part == parts->models[model].part);
  }
  EXPECT_LE(reachOfSurroundings(*parts, 1), 3);
}

TEST_F(MapInParts, ACameraIsFollowedInItsPart) {
  const auto parts = withoutPoses({26});
  Localizer localizer(parts);
  int followed = 0;
  for (std::size_t i = 0; i < drive_on.size(); ++i) {
    const Localization pose = localizer.update(drive_on[i].view, 0.1 * static_cast<double>(i));
    if (pose.tracking != TrackingState::tracking) continue;
    ++followed;
    EXPECT_EQ(pose.hypotheses.front().part, 0);
    const Eigen::Isometry3d T_w_part = *map->models[0].T_w_m * parts->models[0].T_w_m->inverse();
    EXPECT_THAT(T_w_part * pose.T_w_c->T, test::PoseNear(drive_on[i].T_w_c, kCorrect, kCorrectDeg));
    EXPECT_EQ(parts->models[pose.hypotheses.front().model].part, 0);
  }
  EXPECT_GT(followed, static_cast<int>(drive_on.size()) / 2);
}

TEST_F(MapInParts, EachOfSeveralMapsKeepsItsFrame) {
  const auto half = [](std::size_t first) {  // whose world is 100 m off
    auto out = std::make_shared<Map>(*map);
    out->links.clear(), out->models.clear();
    for (std::size_t i = first; i < first + kModels / 2; ++i) {
      out->models.push_back(map->models[i]);
      out->models.back().T_w_m->pretranslate(Eigen::Vector3d(100, 0, 0));
    }
    return out;
  };
  const auto both =
      std::make_shared<const Map>(joinMaps({{"first half", half(0)}, {"second half", half(kModels / 2)}}));
  EXPECT_THAT(both->parts, ElementsAre("first half", "second half"));
  const GlobalLocalization localizer(both), in_one(map);
  int sure = 0, sure_in_one = 0;
  for (const Seen& query : queries) {
    const Localization answer = localizer.localize(query.view);
    sure_in_one += in_one.localize(query.view).state == AnswerState::sure;
    if (answer.state != AnswerState::sure) continue;
    ++sure;
    const Hypothesis& place = answer.hypotheses.front();
    Eigen::Isometry3d truth = query.T_w_c;
    truth.pretranslate(Eigen::Vector3d(100, 0, 0));
    EXPECT_THAT(*place.T_w_c, PoseNear(truth, kCorrect, kCorrectDeg));
    EXPECT_GE(probabilitiesOfMaps(answer, *both).at(both->partOf(place.model)), place.probability);
  }
  EXPECT_GE(sure, 0.8 * sure_in_one);
}

TEST_F(MapInParts, EqualMapsStayDoubtful) {
  const auto both = std::make_shared<const Map>(joinMaps({{"ground", map}, {"first", map}}));
  const GlobalLocalization localizer(both);
  for (std::size_t i = 0; i < queries.size(); i += 3) {
    const Localization answer = localizer.localize(queries[i].view);
    EXPECT_NE(answer.state, AnswerState::sure);
    const auto p = probabilitiesOfMaps(answer, *both);
    EXPECT_NEAR(p.at("ground"), p.at("first"), 0.1);
  }
}

TEST_F(MapInParts, MapsThatCannotBeJoinedAreNamed) {
  EXPECT_THROW(joinMaps({}), std::invalid_argument);
  EXPECT_THROW(joinMaps({{"a", map}, {"a", map}}), std::invalid_argument);
  EXPECT_THROW(joinMaps({{"a/b", map}}), std::invalid_argument);
  auto plan = std::make_shared<Map>(*map);
  setSurfaces(MapSurfaces::fixed, *plan);
  EXPECT_THROW(joinMaps({{"a", map}, {"b", plan}}), std::invalid_argument);
  auto other = std::make_shared<Map>(*map);
  other->camera.mounting->height += 0.5;
  EXPECT_TRUE(joinMaps({{"a", map}, {"b", map}}).camera.mounting);
  EXPECT_FALSE(joinMaps({{"a", map}, {"b", other}}).camera.mounting);
}

}  // namespace
}  // namespace facetloc
