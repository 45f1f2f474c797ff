// SPDX-License-Identifier: BSD-3-Clause
// Queries of global localization to a place index.
#include "pairs/view_registration.h"
#include "place_index_rooms.h"
#include "ranking/global_localization.h"
#include "shortlist/shortlist.h"

#include <facetloc/localization/place_index.h>
#include <facetloc/testing/matchers.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

using namespace internal;
using test::allBatches, test::kMounting, test::onFloor, test::PlaceIndexOfRooms;

std::vector<int> modelsOf(const Batch& batch) {
  std::vector<int> models;
  for (const Start& s : batch) models.push_back(s.model);
  return models;
}

// All models that a view of the map's camera is registered with, batch by batch.
std::vector<int> modelsOf(const std::vector<Batch>& batches) {
  std::vector<int> models;
  for (const Batch& batch : batches)
    for (const Start& s : batch) models.push_back(s.model);
  return models;
}
std::vector<int> modelsFor(const View& view, const Shortlist& shortlist, int threads = 1) {
  return modelsOf(allBatches(shortlist, onFloor(view), true, threads));
}

std::vector<int> sorted(std::vector<int> models) {
  std::sort(models.begin(), models.end());
  return models;
}

TEST_F(PlaceIndexOfRooms, AShortlistWithTheRightModelGivesTheAnswerOfAllModels) {
  GlobalLocalizationParams params;
  params.shortlist.size = 0;
  const GlobalLocalization all(map, params);
  params.shortlist.exhaustive_up_to = 0;
  params.shortlist.size = params.shortlist.examined_models = 20;
  params.shortlist.gap = params.shortlist.examined_gap = 1e6;
  params.shortlist.aligned_models = 40;
  const GlobalLocalization from_starts(map, params);
  params.shortlist.start_translation = 0;
  const GlobalLocalization some(map, params);
  const Shortlist shortlist(map, params);
  int compared = 0;
  for (unsigned i = 0; i < 8; ++i) {
    const View view = query(int(i % kRooms), 0.7 * i, 700 + i);
    const Localization whole = all.localize(view), brief = some.localize(view);
    if (whole.hypotheses.empty()) continue;
    for (const Batch& batch : allBatches(shortlist, onFloor(view), true, 1)) {
      const std::vector<int> models = modelsOf(batch);
      EXPECT_TRUE(std::is_sorted(models.begin(), models.end()));
    }
    const std::vector<int> list = sorted(modelsFor(view, shortlist));
    EXPECT_LE(list.size(), 20u);
    EXPECT_GT(list.size(), 10u);
    if (!std::binary_search(list.begin(), list.end(), whole.hypotheses[0].model)) continue;
    ++compared;
    // A room that looks the same in this view may come first: one more of its models has found it.
    const auto isAsLikely = [&](const Localization& answer, double translation, double rotation_deg) {
      return std::any_of(answer.hypotheses.begin(), answer.hypotheses.end(), [&](const Hypothesis& h) {
        return isNear(*h.T_w_c, *whole.hypotheses[0].T_w_c, translation, rotation_deg) &&
               h.probability > 0.75 * answer.hypotheses[0].probability;
      });
    };
    EXPECT_TRUE(isAsLikely(brief, 1e-9, 1e-6)) << i;
    // Started where the alignments lead to, it finds the same place, perhaps by another model.
    EXPECT_TRUE(isAsLikely(from_starts.localize(view), 0.02, 0.3)) << i;
  }
  EXPECT_GE(compared, 4);
}

TEST_F(PlaceIndexOfRooms, ShortlistsTheBestAlignedAndTheBestExaminedModels) {
  constexpr int kAligned = 30, kFirst = 2, kListed = 6;
  GlobalLocalizationParams params;
  params.shortlist = few();
  params.shortlist.exhaustive_up_to = 0, params.shortlist.examined_models = kAligned;
  params.shortlist.first_models = kFirst, params.shortlist.examined_gap = 1e6;
  std::vector<Shortlist> shortlists;  // with one model, with two, ...: each has one more of those below it
  for (params.shortlist.size = 1; params.shortlist.size <= kListed; ++params.shortlist.size)
    shortlists.emplace_back(map, params);
  params.shortlist.size = kListed;
  PosePriorParams about_start;
  about_start.translation_std = params.shortlist.start_translation;
  about_start.rotation_std_deg = 3;
  const PlaceIndex index(*map, params.shortlist);
  const ViewRegistration registration;
  int moved = 0, threads = 1;
  for (unsigned i = 0; i < 4; ++i) {
    const View view = query(int(i), 0.7 * i, 800 + i);
    std::vector<int> expected;
    std::vector<std::pair<double, int>> others;  // the highest score first
    std::map<int, PoseWithCovariance> start;
    for (const ShortlistedModel& c : index.candidates(view, kAligned)) {
      ASSERT_TRUE(c.start);
      start[c.model] = {*c.start, posePrior(kMounting, about_start, *c.start)};
      if (c.rank < kFirst) {
        expected.push_back(c.model);
        continue;
      }
      const auto h = registration.alignFrom(start[c.model], onFloor(view), *map->view(c.model));
      if (h) others.emplace_back(-h->score, c.model);
    }
    std::sort(others.begin(), others.end());
    for (int k = 0; k < kListed - kFirst; ++k) expected.push_back(others.at(k).second);
    std::vector<int> by_rank;
    for (const Shortlist& shortlist : shortlists)
      for (const int model : modelsFor(view, shortlist, threads))
        if (std::find(by_rank.begin(), by_rank.end(), model) == by_rank.end()) by_rank.push_back(model);
    EXPECT_EQ(by_rank, expected) << i;
    const std::vector<Batch> batches = allBatches(shortlists.back(), onFloor(view), true, threads);
    ASSERT_EQ(batches.size(), 2u);
    EXPECT_EQ(modelsOf(batches[0]), sorted({expected.begin(), expected.begin() + kFirst})) << i;
    EXPECT_EQ(modelsOf(batches[1]), sorted({expected.begin() + kFirst, expected.end()})) << i;
    for (const Batch& batch : batches)
      for (const Start& s : batch) {
        EXPECT_EQ(s.T_m_c.T.matrix(), start[s.model].T.matrix());
        EXPECT_EQ(s.T_m_c.P, start[s.model].P);
      }
    moved += by_rank != index.shortlist(view, kListed);

    // Without those that come so far behind.
    GlobalLocalizationParams close = params;
    close.shortlist.examined_gap = 0.5 * (others[1].first + others[2].first) - others[0].first;
    EXPECT_EQ(modelsFor(view, Shortlist(map, close), threads).size(), std::size_t{kFirst + 2}) << i;
    // None of the models that were registered already.
    const Query query = onFloor(view);
    const Shortlist shortlist(map, close);
    EXPECT_TRUE(shortlist.batches(query, true, threads).back()(1e6).empty()) << i;
    threads = 3;  // to no effect
  }
  EXPECT_GT(moved, 0) << "alignments alone tell as much";
}

TEST_F(PlaceIndexOfRooms, AnExaminedModelThatCannotBeReadIsAnErrorForAnyNumberOfThreads) {
  struct Store : MapStore {
    std::shared_ptr<const View> view(int i) const override {
      if (i == damaged) throw std::runtime_error("local model " + std::to_string(i) + " is damaged");
      return intact->view(i);
    }
    std::shared_ptr<const Map> intact = map;
    int damaged = -1;
  };
  GlobalLocalizationParams params;
  params.shortlist = few();
  params.shortlist.exhaustive_up_to = 0, params.shortlist.examined_models = 20;
  params.shortlist.size = 15, params.shortlist.examined_gap = 1e6;
  const View view = query(2, 0.7, 802);
  const std::vector<int> aligned =
      PlaceIndex(*map, params.shortlist).shortlist(view, params.shortlist.aligned_models);
  const auto store = std::make_shared<Store>();
  auto stored = std::make_shared<Map>(*map);
  stored->setStore(store);
  const Shortlist shortlist(stored, params);
  for (const int threads : {1, 2}) {
    store->damaged = aligned.at(25);  // aligned, but not examined
    EXPECT_EQ(modelsFor(view, shortlist, threads).size(), std::size_t{15});
    store->damaged = aligned.at(19);
    EXPECT_EQ(test::messageOf<std::runtime_error>([&] { modelsFor(view, shortlist, threads); }),
              "local model " + std::to_string(store->damaged) + " is damaged");
  }
}

TEST_F(PlaceIndexOfRooms, WithoutJointRefinementAnAlignmentIsNoMeasurementEither) {
  GlobalLocalizationParams params;
  params.shortlist.exhaustive_up_to = 0, params.steps.joint_refinement = false;
  params.shortlist.size = 1000;  // list of all models, in whatever order
  params.shortlist.gap = 1e6;
  const View view = query(1, 0.4, 77);
  const Localization with_starts = GlobalLocalization(map, params).localize(view);
  params.shortlist.start_translation = 0;
  const Localization without = GlobalLocalization(map, params).localize(view);
  ASSERT_FALSE(without.hypotheses.empty());
  ASSERT_EQ(with_starts.hypotheses.size(), without.hypotheses.size());
  EXPECT_EQ(with_starts.hypotheses[0].T_m_c.P, without.hypotheses[0].T_m_c.P);
}

/** Knows which local models were asked for, in which order. One thread only. */
struct ListeningStore : MapStore {
  explicit ListeningStore(std::shared_ptr<const Map> map) : of(std::move(map)) {}
  std::shared_ptr<const View> view(int i) const override {
    asked.push_back(i);
    return of->view(i);
  }
  std::shared_ptr<const Map> of;
  mutable std::vector<int> asked;
};

/** The local models that global localization registers a view with. */
std::vector<int> askedFor(const View& view, const std::shared_ptr<const Map>& map,
                          GlobalLocalizationParams params) {
  params.evidence.enabled = false;  // which asks them, too
  const auto store = std::make_shared<ListeningStore>(map);
  auto stored = std::make_shared<Map>(*map);
  stored->setStore(store);
  const GlobalLocalization localization(stored, params);
  store->asked.clear();  // queries of the index
  EXPECT_FALSE(localization.localize(view).hypotheses.empty());
  return store->asked;
}

TEST_F(PlaceIndexOfRooms, ASureAnswerOfTheLikeliestModelsStopsTheSearch) {
  GlobalLocalizationParams params;
  params.shortlist.exhaustive_up_to = 0;
  params.shortlist.gap = params.shortlist.examined_gap = 1e6;
  params.shortlist.examined_models = params.shortlist.size, params.shortlist.first_models = 4;
  const View view = query(1, 0.4, 77);
  const std::vector<Batch> batches = allBatches(Shortlist(map, params), onFloor(view), true, 1);
  ASSERT_EQ(batches.size(), 2u);
  const PlaceIndex index(*map, params.shortlist);
  EXPECT_EQ(batches[0].size(), 4u);
  EXPECT_EQ(modelsOf(batches[0]), sorted(index.shortlist(view, 4)));
  EXPECT_EQ(sorted(modelsOf(batches)), sorted(index.shortlist(view, params.shortlist.size)));
  params.shortlist.sure_probability = 0;
  EXPECT_EQ(askedFor(view, map, params), modelsOf(batches[0]));
  params.shortlist.sure_probability = 1;
  const std::vector<int> asked = askedFor(view, map, params);  // others are examined first
  const std::vector<int> registered(asked.end() - static_cast<std::ptrdiff_t>(batches[1].size()),
                                    asked.end());
  EXPECT_EQ(registered, modelsOf(batches[1]));
}

TEST_F(PlaceIndexOfRooms, OverlapScoresStopNoSearch) {
  GlobalLocalizationParams params;
  params.shortlist.exhaustive_up_to = 0, params.shortlist.gap = 1e6, params.shortlist.first_models = 4;
  params.shortlist.sure_probability = 0, params.score.by_overlap = true;
  params.shortlist.examined_models = params.shortlist.size;
  const View view = query(1, 0.4, 77);
  const std::vector<int> asked = askedFor(view, map, params);
  EXPECT_EQ(asked, modelsFor(view, Shortlist(map, params)));
  EXPECT_GT(asked.size(), 4u);
}

TEST_F(PlaceIndexOfRooms, ASmallMapIsSearchedAsAWhole) {
  const View view = viewOf(0);
  GlobalLocalizationParams small;
  small.shortlist.exhaustive_up_to = static_cast<int>(map->models.size());
  EXPECT_EQ(modelsFor(view, Shortlist(map, small)).size(), map->models.size());
  GlobalLocalizationParams off;
  off.shortlist.exhaustive_up_to = 0, off.shortlist.size = 0;
  EXPECT_EQ(modelsFor(view, Shortlist(map, off)).size(), map->models.size());
}

TEST_F(PlaceIndexOfRooms, AViewThatHasNothingToLookUpIsRegisteredWithAll) {
  GlobalLocalizationParams params;
  params.shortlist.exhaustive_up_to = 0;
  const Shortlist shortlist(map, params);
  EXPECT_LT(modelsFor(viewOf(0), shortlist).size(), map->models.size());
  // A room on one of its corners: neither walls nor level surfaces.
  View oblique = query(0, 0, 78);
  const Eigen::Matrix3d R_b_c = kMounting.T_b_c().linear();
  const Eigen::Isometry3d onto_corner(R_b_c.transpose() *
                                      rotationBetween({1, 1, 1}, Eigen::Vector3d::UnitZ()) * R_b_c);
  for (Segment& s : oblique.segments) s = transformed(s, onto_corner);
  ASSERT_TRUE(PlaceIndex(*map).shortlist(oblique, 10).empty());
  EXPECT_EQ(modelsFor(oblique, shortlist).size(), map->models.size());
  const std::vector<Batch> of_nothing = allBatches(shortlist, onFloor(View{}), true, 1);
  ASSERT_EQ(of_nothing.size(), 1u);  // which fixes no pose, whatever the model
  EXPECT_TRUE(of_nothing[0].empty());
}

TEST_F(PlaceIndexOfRooms, AWiderPriorThanTheUsualOneIsSearchedInAllModels) {
  const View view = viewOf(5);
  GlobalLocalizationParams params;
  params.shortlist.exhaustive_up_to = 0;
  const auto models = [&] {
    return modelsOf(allBatches(Shortlist(map, params), onFloor(view, params.prior), true, 1)).size();
  };
  EXPECT_LT(models(), map->models.size());
  params.prior.rotation_std_deg *= 2;
  EXPECT_EQ(models(), map->models.size());
  params.prior = {};
  params.prior.translation_std *= 2;
  EXPECT_EQ(models(), map->models.size());

  // The camera looks the other way: about each model where nothing is compared.
  PoseWithCovariance turned = GlobalLocalization(map).prior(view);
  EXPECT_TRUE(PlaceIndex::covers(turned));
  turned.T.linear() = expSO3({0, -120 * kDegree, 0});
  EXPECT_FALSE(PlaceIndex::covers(turned));
  turned.P *= 0.01;
  EXPECT_FALSE(PlaceIndex::covers(turned));
  turned.T.linear() = expSO3({0, -30 * kDegree, 0});
  EXPECT_TRUE(PlaceIndex::covers(turned));
  turned.T.translation().z() = 5;
  EXPECT_FALSE(PlaceIndex::covers(turned));
}

Query inTheHand(const View& view) {
  PoseWithCovariance prior{Eigen::Isometry3d::Identity(), posePrior({})};
  return Query(view, prior);
}

std::vector<int> different(std::vector<int> models) {
  std::sort(models.begin(), models.end());
  models.erase(std::unique(models.begin(), models.end()), models.end());
  return models;
}

TEST_F(PlaceIndexOfRooms, ACameraInAnyAttitudeIsLookedForInTheLikeliestModelsFirst) {
  GlobalLocalizationParams params;
  params.shortlist.examined_gap = 1e6;
  const View view = query(1, 0.4, 77);
  const Query in_the_hand = inTheHand(view);
  const std::vector<Batch> batches =
      allBatches(Shortlist(map, params), in_the_hand, false, 1, {}, internal::kByChance);
  ASSERT_EQ(batches.size(), 3u);
  EXPECT_EQ(batches[0].size(), 3u);
  EXPECT_EQ(batches[1].size(), 10u);
  for (const Batch& batch : batches) {
    const std::vector<int> models = modelsOf(batch);
    EXPECT_TRUE(std::is_sorted(models.begin(), models.end()));
  }
  // The likeliest about where they are laid over the view, then with others about the prior.
  for (const Start& s : batches[0]) EXPECT_LT(s.T_m_c.P(3, 3), in_the_hand.prior.P(3, 3));
  for (const Start& s : batches[1]) EXPECT_EQ(s.T_m_c.P, in_the_hand.prior.P);
  const std::vector<int> again = different(modelsOf(batches[1])), first = modelsOf(batches[0]);
  EXPECT_TRUE(std::includes(again.begin(), again.end(), first.begin(), first.end()));
  EXPECT_GT(different(modelsOf(batches)).size(), 0.8 * static_cast<double>(map->models.size()))
      << "all whose planes agree at all where they are laid over the view";
  const Batch if_hopeless = allBatches(Shortlist(map, params), in_the_hand, false, 1)[2];
  EXPECT_LT(if_hopeless.size(), batches[2].size());
  for (const Start& s : if_hopeless) EXPECT_TRUE(s.is_aligned) << "the others are of use if a place is found";
  GlobalLocalizationParams narrow;
  narrow.shortlist.examined_gap = 5;
  EXPECT_LT(allBatches(Shortlist(map, narrow), in_the_hand, false, 1)[2].size(), batches[2].size() / 2);

  const std::vector<Batch> by_four =
      allBatches(Shortlist(map, params), in_the_hand, false, 4, {}, internal::kByChance);
  for (std::size_t i = 0; i < batches.size(); ++i) EXPECT_EQ(modelsOf(by_four[i]), modelsOf(batches[i]));
  params.shortlist.overlaid_size = 25;
  const std::size_t few =
      different(modelsOf(allBatches(Shortlist(map, params), in_the_hand, false, 1))).size();
  EXPECT_GT(few, 10u);
  EXPECT_LE(few, 25u);
  const int excluded = first[0];
  const auto without = modelsOf(
      allBatches(Shortlist(map, params), in_the_hand, false, 1, [&](int m) { return m == excluded; }));
  EXPECT_EQ(std::count(without.begin(), without.end(), excluded), 0);

  params.shortlist.start_translation = 0;
  const Shortlist about_the_prior(map, params);
  for (const Batch& batch : allBatches(about_the_prior, in_the_hand, false, 1))
    for (const Start& s : batch) EXPECT_EQ(s.T_m_c.P, in_the_hand.prior.P);
  params.shortlist.size = 0;
  EXPECT_EQ(allBatches(Shortlist(map, params), in_the_hand, false, 1).size(), 1u);
}

TEST_F(PlaceIndexOfRooms, ACameraInTheHandIsLookedForInAllModelsOfAMapInItsFile) {
  const Shortlist in_file(map, {}), in_memory(test::inMemory(*map), {});
  ASSERT_TRUE(map->store());
  for (int model = 3; model < kRooms * kViews; model += 31) {
    View view = viewOf(model);
    view.camera = nullptr;
    const auto found = allBatches(in_file, inTheHand(view), false, 1),
               expected = allBatches(in_memory, inTheHand(view), false, 1);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(modelsOf(found[i]), modelsOf(expected[i]));
    const std::vector<int> first = modelsOf(found[0]);
    EXPECT_EQ(std::count(first.begin(), first.end(), model), 1) << "an image of the map is laid over itself";
  }
}

TEST_F(PlaceIndexOfRooms, AModelRegisteredAnewCountsOnce) {
  auto in_the_hand = std::make_shared<Map>(*map);
  in_the_hand->camera.mounting.reset();
  GlobalLocalizationParams params;
  params.shortlist.size = 0;
  const GlobalLocalization all(in_the_hand, params);
  params.shortlist.size = 40;
  params.shortlist.sure_probability = 1;  // so that all batches are asked
  params.shortlist.examined_gap = 1e6;
  const GlobalLocalization by_batches(in_the_hand, params);
  int compared = 0, equal = 0;
  for (unsigned i = 0; i < 8; ++i) {
    View view = query(int(i % kRooms), 0.7 * i, 700 + i);
    view.camera = nullptr;
    const Localization whole = all.localize(view), brief = by_batches.localize(view);
    if (whole.hypotheses.empty()) continue;
    ++compared;
    ASSERT_FALSE(brief.hypotheses.empty());
    equal += isNear(*brief.hypotheses[0].T_w_c, *whole.hypotheses[0].T_w_c, 0.05, 1);
    for (std::size_t a = 0; a < brief.hypotheses.size(); ++a)
      for (std::size_t b = 0; b < a; ++b)
        EXPECT_FALSE(brief.hypotheses[a].model == brief.hypotheses[b].model &&
                     isNear(brief.hypotheses[a].T_m_c.T, brief.hypotheses[b].T_m_c.T, 1e-3, 0.01));
  }
  EXPECT_GT(compared, 4);
  EXPECT_GE(equal, compared - 1);
}

TEST_F(PlaceIndexOfRooms, FloorAndShortlistNeedTheMountingOfTheMapsCamera) {
  GlobalLocalizationParams params;
  params.shortlist.exhaustive_up_to = 0;
  const GlobalLocalization localization(map, params);
  using Mounting = CameraDifference::Mounting;
  const auto expectAll = [&](const View& view, Mounting mounting) {
    EXPECT_EQ(localization.prior(view).P, posePrior({}));
    GlobalLocalizationParams until_sure = params;
    until_sure.shortlist.sure_probability = 1;
    EXPECT_EQ(different(askedFor(view, map, until_sure)).size(), map->models.size());
    EXPECT_EQ(localization.localize(view).camera.mounting, mounting);
  };
  View view = query(1, 0.4, 77);
  EXPECT_EQ(localization.prior(view).P, posePrior(kMounting));
  EXPECT_LT(askedFor(view, map, params).size(), map->models.size());
  EXPECT_EQ(localization.localize(view).camera.mounting, Mounting::same);
  expectAll(test::mounted(view, CameraMounting{kMounting.height + 0.1, kMounting.tilt_deg}), Mounting::other);
  for (const auto& camera : {std::make_shared<const Camera>(), std::shared_ptr<const Camera>()}) {
    view.camera = camera;
    EXPECT_EQ(localization.localize(view).camera.mounting, Mounting::same) << "its planes show it";
    View turned = view;
    const Eigen::Isometry3d roll(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
    for (Segment& segment : turned.segments) segment = transformed(segment, roll);
    expectAll(turned, Mounting::unknown);
  }
}

TEST(PlaceIndex, CoversThePriorOfAHighCameraOnAnUnevenFloor) {
  PosePriorParams uneven;
  uneven.robot.floor_std = 0.02;
  EXPECT_TRUE(PlaceIndex::covers({Eigen::Isometry3d::Identity(), posePrior(CameraMounting{4, 20})}));
  EXPECT_TRUE(
      PlaceIndex::covers({Eigen::Isometry3d::Identity(), posePrior(CameraMounting{1.2, 10}, uneven)}));
}

}  // namespace
}  // namespace facetloc
