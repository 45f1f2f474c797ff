// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/global_localization.h>
#include <facetloc/registration/place_index.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <sys/resource.h>

namespace facetloc {
namespace {

constexpr CameraMounting kMounting{1.0, 10.0};

Eigen::Isometry3d robotCamera(double x, double y, double heading) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = expSO3({0, 0, heading});
  T.translation() << x, y, 0;
  return T * kMounting.T_b_c();
}

// Views of the room all around from two places; four rooms in a row, each with one more cupboard.
class PlaceIndexOfRooms : public testing::Test {
protected:
  static constexpr int kRooms = 4, kViews = 24;
  static test::Scene room(int i) {
    test::Scene scene = test::largeRoom();
    if (i & 1) scene = scene + test::box({3.4, 0, 0}, {4.3, 0.4, 2.1});
    if (i & 2) scene = scene + test::box({5.5, 2.6, 0}, {6, 3.0, 2.0});
    return scene;
  }
  static void SetUpTestSuite() {
    auto made = std::make_shared<Map>();
    made->mounting = kMounting;
    for (int r = 0; r < kRooms; ++r)
      for (int i = 0; i < kViews; ++i) {
        const Eigen::Isometry3d T = robotCamera(i < kViews / 2 ? 2 : 3.2, 2.4, 30 * kDegree * i);
        LocalModel m;
        m.name = std::to_string(r) + "/" + std::to_string(i);
        m.T_w_m = T;
        m.T_w_m->pretranslate(Eigen::Vector3d(20.0 * r, 0, 0));
        m.view = viewFrom(room(r), T, unsigned(100 + r * kViews + i));
        made->models.push_back(m);
      }
    map = made;
  }
  static void TearDownTestSuite() { map.reset(); }
  static View query(int r, double heading, unsigned seed) {
    return viewFrom(room(r), robotCamera(2.3, 2.2, heading), seed);
  }
  static PlaceIndexParams few() {
    PlaceIndexParams params;
    params.aligned_models = 30;
    params.shortlist_gap = 1e6;
    return params;
  }
  static std::shared_ptr<const Map> map;
};
std::shared_ptr<const Map> PlaceIndexOfRooms::map;

std::vector<int> modelsOf(const std::vector<Candidate>& candidates) {
  std::vector<int> models;
  for (const Candidate& c : candidates) models.push_back(c.model);
  return models;
}

TEST_F(PlaceIndexOfRooms, EveryModelLeadsItsOwnList) {
  const PlaceIndex index(*map, few());
  EXPECT_EQ(index.models(), map->models.size());
  EXPECT_GT(index.descriptors(), map->models.size());
  EXPECT_GT(index.bytes(), 0u);
  // Most views are alike in all rooms, but for the noise.
  int near_front = 0;
  for (std::size_t i = 0; i < map->models.size(); ++i) {
    const std::vector<int> list = index.shortlist(map->models[i].view, kRooms);
    ASSERT_EQ(list.size(), kRooms);
    EXPECT_EQ(list.front() % kViews, static_cast<int>(i) % kViews);
    near_front += std::count(list.begin(), list.end(), static_cast<int>(i));
  }
  EXPECT_GE(near_front, 0.95 * static_cast<double>(map->models.size()));
}

TEST_F(PlaceIndexOfRooms, TheSameMapGivesTheSameList) {
  const PlaceIndex one(*map, few()), other(*map, few());
  for (unsigned i = 0; i < 6; ++i) {
    const View view = query(int(i % kRooms), 0.9 * i, 500 + i);
    const std::vector<int> list = one.shortlist(view, 20);
    EXPECT_EQ(list, other.shortlist(view, 20));
    EXPECT_EQ(list, one.shortlist(view, 20));
    std::vector<int> sorted = list;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(std::unique(sorted.begin(), sorted.end()), sorted.end());
    const std::vector<int> shorter = one.shortlist(view, 7);
    EXPECT_EQ(shorter, std::vector<int>(list.begin(), list.begin() + 7));
  }
}

TEST_F(PlaceIndexOfRooms, AViewWithHalfOfItsSegmentsFindsItsPlace) {
  const PlaceIndex index(*map, few());
  for (unsigned i = 0; i < 6; ++i) {
    const double heading = 30 * kDegree * i + 0.1;
    View view = query(0, heading, 600 + i);
    std::vector<Segment> half;
    for (std::size_t k = 0; k < view.segments.size(); k += 2) half.push_back(view.segments[k]);
    view.segments = half;
    const std::vector<int> list = index.shortlist(view, 20);
    // Any room's: half of the segments need not tell which.
    const Eigen::Isometry3d truth = robotCamera(2.3, 2.2, heading);
    EXPECT_TRUE(std::any_of(list.begin(), list.end(), [&](int m) {
      return rotationAngle(map->models[m].T_w_m->linear().transpose() * truth.linear()) < 25 * kDegree;
    })) << heading;
  }
}

TEST_F(PlaceIndexOfRooms, TheShortlistedAnswerIsThatOfAllModelsIfTheListHoldsTheRightOne) {
  GlobalLocalizationParams params;
  params.index.shortlist = 0;
  const GlobalLocalization all(map, params);
  params.index.exhaustive_up_to = 0;
  params.index.shortlist = 20;
  params.index.shortlist_gap = 1e6;
  params.index.aligned_models = 40;
  const GlobalLocalization from_starts(map, params);
  params.index.start_translation = 0;
  const GlobalLocalization some(map, params);
  int compared = 0;
  for (unsigned i = 0; i < 8; ++i) {
    const View view = query(int(i % kRooms), 0.7 * i, 700 + i);
    const Localization whole = all.localize(view), brief = some.localize(view);
    if (whole.hypotheses.empty()) continue;
    const std::vector<int> list = modelsOf(some.candidates(view));
    EXPECT_EQ(list.size(), 20u);
    EXPECT_TRUE(std::is_sorted(list.begin(), list.end()));
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
    // From where the alignments lead to, the place is the same, perhaps by another model.
    EXPECT_TRUE(isAsLikely(from_starts.localize(view), 0.02, 0.3)) << i;
  }
  EXPECT_GE(compared, 4);
}

TEST_F(PlaceIndexOfRooms, TheShortlistIsOfTheBestAlignedAndOfThoseWithWhosePlanesTheViewAgreesBest) {
  constexpr int kAligned = 30, kFirst = 2, kListed = 6;
  GlobalLocalizationParams params;
  params.index = few();
  params.index.exhaustive_up_to = 0;
  params.index.examined_models = kAligned;
  params.index.first_models = kFirst;
  params.index.shortlist = kListed;
  params.index.examined_gap = 1e6;
  GlobalLocalization localization(map, params);
  PosePriorParams about_start;
  about_start.translation_std = params.index.start_translation;
  about_start.rotation_std_deg = params.index.start_rotation_deg;
  const PlaceIndex index(*map, params.index);
  const ViewRegistration registration;
  int moved = 0;
  for (unsigned i = 0; i < 4; ++i) {
    const View view = query(int(i), 0.7 * i, 800 + i);
    std::vector<int> expected;
    std::vector<std::pair<double, int>> others;  // the highest score first
    for (const Candidate& c : index.candidates(view, kAligned)) {
      ASSERT_TRUE(c.start);
      if (c.rank < kFirst) {
        expected.push_back(c.model);
        continue;
      }
      const auto h = registration.alignFrom({*c.start, posePrior(kMounting, about_start, *c.start)}, view,
                                            samplePoints(view), map->models[c.model].view);
      if (h) others.emplace_back(-h->score, c.model);
    }
    std::sort(others.begin(), others.end());
    for (int k = 0; k < kListed - kFirst; ++k) expected.push_back(others.at(k).second);
    std::vector<int> by_rank(kListed, -1);
    for (const Candidate& c : localization.candidates(view)) by_rank.at(c.rank) = c.model;
    EXPECT_EQ(by_rank, expected) << i;
    moved += by_rank != index.shortlist(view, kListed);

    // Without those that come so far behind.
    GlobalLocalizationParams close = params;
    close.index.examined_gap = 0.5 * (others[1].first + others[2].first) - others[0].first;
    EXPECT_EQ(GlobalLocalization(map, close).candidates(view).size(), std::size_t{kFirst + 2}) << i;
    // Where all are aligned, alignments are enough.
    close.index.aligned_models = static_cast<int>(map->models.size());
    std::vector<int> aligned = PlaceIndex(*map, close.index).shortlist(view, kListed);
    std::sort(aligned.begin(), aligned.end());
    EXPECT_EQ(modelsOf(GlobalLocalization(map, close).candidates(view)), aligned) << i;
    localization.setNumberOfThreads(3);  // to no effect
  }
  EXPECT_GT(moved, 0) << "alignments alone tell as much";
}

TEST_F(PlaceIndexOfRooms, AnExaminedModelThatCannotBeReadIsAnErrorForAnyNumberOfThreads) {
  struct Store : MapStore {
    std::shared_ptr<const View> view(int i) const override {
      if (i == damaged) throw std::runtime_error("local model " + std::to_string(i) + " is damaged");
      return std::make_shared<View>(intact->models[i].view);
    }
    std::unique_ptr<std::istream> placeIndex() const override { return nullptr; }
    std::shared_ptr<const Map> intact = map;
    int damaged = -1;
  };
  GlobalLocalizationParams params;
  params.index = few();
  params.index.exhaustive_up_to = 0;
  params.index.examined_models = 20;
  params.index.shortlist = 15;
  params.index.examined_gap = 1e6;
  const View view = query(2, 0.7, 802);
  const std::vector<int> aligned =
      PlaceIndex(*map, params.index).shortlist(view, params.index.aligned_models);
  const auto store = std::make_shared<Store>();
  auto stored = std::make_shared<Map>(*map);
  stored->store = store;
  GlobalLocalization localization(stored, params);
  for (const int threads : {1, 2}) {
    localization.setNumberOfThreads(threads);
    store->damaged = aligned.at(25);  // aligned, but not examined
    EXPECT_EQ(localization.candidates(view).size(), std::size_t{15});
    store->damaged = aligned.at(19);
    try {
      localization.candidates(view);
      FAIL() << "the damage was not told";
    } catch (const std::runtime_error& e) {
      EXPECT_EQ(e.what(), "local model " + std::to_string(store->damaged) + " is damaged");
    }
  }
}

TEST_F(PlaceIndexOfRooms, HopelessModelsAreLeftOut) {
  const View view = query(1, 0.7, 701);
  const auto listed = [&](double gap) {
    PlaceIndexParams params = few();
    params.shortlist_gap = gap;
    return PlaceIndex(*map, params).shortlist(view, 1000);
  };
  const std::vector<int> best = listed(0), some = listed(0.5), all = listed(1e6);
  EXPECT_LE(best.size(), 2u);
  EXPECT_LT(best.size(), some.size());
  EXPECT_LT(some.size(), all.size());
  EXPECT_TRUE(std::equal(some.begin(), some.end(), all.begin()));  // the same order, cut short
}

TEST_F(PlaceIndexOfRooms, CandidatesTellAboutWhereTheViewIsInThem) {
  const PlaceIndex index(*map, few());
  int near = 0, all = 0;
  for (unsigned i = 0; i < 12; ++i) {
    const double heading = 30 * kDegree * i + 0.1;
    const Eigen::Isometry3d truth = robotCamera(2.3, 2.2, heading);
    const std::vector<Candidate> found = index.candidates(query(0, heading, 400 + i), 4);
    ASSERT_FALSE(found.empty());
    for (const Candidate& c : found) {
      if (c.model >= kViews) continue;  // of another room
      ASSERT_TRUE(c.start);
      EXPECT_TRUE(c.start->linear().isUnitary(1e-9));
      const Vector6d e = perturbation(*c.start, map->models[c.model].T_w_m->inverse() * truth);
      near += e.head<3>().norm() < 5 * kDegree && e.tail<3>().norm() < 0.4;
      ++all;
    }
  }
  EXPECT_GE(all, 12);
  EXPECT_GE(near, 0.9 * all);
}

TEST_F(PlaceIndexOfRooms, WithoutStartsEveryCandidateIsSearchedEverywhere) {
  PlaceIndexParams params = few();
  params.start_translation = 0;
  for (const Candidate& c : PlaceIndex(*map, params).candidates(query(1, 0.4, 77), 10)) EXPECT_FALSE(c.start);
}

TEST_F(PlaceIndexOfRooms, WithoutJointRefinementAnAlignmentIsNoMeasurementEither) {
  GlobalLocalizationParams params;
  params.index.exhaustive_up_to = 0;
  params.registration.joint_refinement = false;
  params.index.shortlist = 1000;  // of all models, in whatever order
  params.index.shortlist_gap = 1e6;
  const View view = query(1, 0.4, 77);
  const Localization with_starts = GlobalLocalization(map, params).localize(view);
  params.index.start_translation = 0;
  const Localization without = GlobalLocalization(map, params).localize(view);
  ASSERT_FALSE(without.hypotheses.empty());
  ASSERT_EQ(with_starts.hypotheses.size(), without.hypotheses.size());
  EXPECT_EQ(with_starts.hypotheses[0].T_m_c.P, without.hypotheses[0].T_m_c.P);
}

TEST_F(PlaceIndexOfRooms, WhatTheLikeliestModelsShowBeyondDoubtIsNotSearchedForInTheOthers) {
  GlobalLocalizationParams params;
  params.index.exhaustive_up_to = 0;
  params.index.shortlist_gap = 1e6;
  params.index.first_models = 4;
  const View view = query(1, 0.4, 77);
  const auto asked = [&](double sure_probability) {
    params.index.sure_probability = sure_probability;
    const GlobalLocalization localization(map, params);
    std::vector<std::vector<Candidate>> rounds;
    const Localization answer = localization.localizeBy(
        [&](const std::vector<Candidate>& candidates) {
          rounds.push_back(candidates);
          return localization.registerWith(candidates, view, localization.prior());
        },
        view);
    EXPECT_FALSE(answer.hypotheses.empty());
    return rounds;
  };
  const auto sure = asked(0), doubtful = asked(1);
  const std::vector<Candidate> all = GlobalLocalization(map, params).candidates(view);
  ASSERT_EQ(sure.size(), 1u);
  ASSERT_EQ(doubtful.size(), 2u);
  EXPECT_EQ(sure[0].size(), 4u);
  for (const Candidate& c : sure[0]) EXPECT_LT(c.rank, 4);
  EXPECT_EQ(modelsOf(doubtful[0]), modelsOf(sure[0]));
  EXPECT_EQ(doubtful[0].size() + doubtful[1].size(), all.size());
  for (const Candidate& c : doubtful[1]) EXPECT_GE(c.rank, 4);
}

TEST_F(PlaceIndexOfRooms, AProbabilityBySurfaceScoreLeavesNobodyUnasked) {
  GlobalLocalizationParams params;
  params.index.exhaustive_up_to = 0;
  params.index.shortlist_gap = 1e6;
  params.index.first_models = 4;
  params.index.sure_probability = 0;
  params.registration.consensus.surface_score = true;
  const GlobalLocalization localization(map, params);
  const View view = query(1, 0.4, 77);
  std::size_t asked = 0;
  localization.localizeBy(
      [&](const std::vector<Candidate>& candidates) {
        asked += candidates.size();
        return localization.registerWith(candidates, view, localization.prior());
      },
      view);
  EXPECT_EQ(asked, localization.candidates(view).size());
  EXPECT_GT(asked, 4u);
}

TEST_F(PlaceIndexOfRooms, ASmallMapIsSearchedAsAWhole) {
  GlobalLocalizationParams small;
  small.index.exhaustive_up_to = static_cast<int>(map->models.size());
  const GlobalLocalization localization(map, small);
  EXPECT_EQ(localization.candidates(map->models[0].view).size(), map->models.size());
  GlobalLocalizationParams off;
  off.index.exhaustive_up_to = 0;
  off.index.shortlist = 0;
  EXPECT_EQ(GlobalLocalization(map, off).candidates(map->models[0].view).size(), map->models.size());
}

TEST_F(PlaceIndexOfRooms, AViewThatHasNothingToLookUpIsRegisteredWithAll) {
  GlobalLocalizationParams params;
  params.index.exhaustive_up_to = 0;
  const GlobalLocalization localization(map, params);
  EXPECT_LT(localization.candidates(map->models[0].view).size(), map->models.size());
  EXPECT_EQ(localization.candidates(View{}).size(), map->models.size());
}

TEST_F(PlaceIndexOfRooms, AWiderPriorThanTheUsualOneIsSearchedInAllModels) {
  const View& view = map->models[5].view;
  GlobalLocalizationParams params;
  params.index.exhaustive_up_to = 0;
  EXPECT_LT(GlobalLocalization(map, params).candidates(view).size(), map->models.size());
  params.prior.rotation_std_deg *= 2;
  EXPECT_EQ(GlobalLocalization(map, params).candidates(view).size(), map->models.size());
  params.prior = {};
  params.prior.translation_std *= 2;
  EXPECT_EQ(GlobalLocalization(map, params).candidates(view).size(), map->models.size());

  // The camera looks the other way: about each model where nothing is compared.
  PoseWithCovariance turned = GlobalLocalization(map).prior();
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

TEST(PlaceIndex, CoversThePriorOfAHighCameraOnAnUnevenFloor) {
  PosePriorParams uneven;
  uneven.floor_std = 0.02;
  EXPECT_TRUE(PlaceIndex::covers({Eigen::Isometry3d::Identity(), posePrior(CameraMounting{4, 20})}));
  EXPECT_TRUE(
      PlaceIndex::covers({Eigen::Isometry3d::Identity(), posePrior(CameraMounting{1.2, 10}, uneven)}));
}

// Segments of a view that look this way.
View facing(View view, const std::function<bool(const Eigen::Vector3d&)>& keep) {
  std::vector<Segment> kept;
  for (const Segment& s : view.segments)
    if (keep(kMounting.T_b_c().linear() * s.normal())) kept.push_back(s);
  view.segments = kept;
  return view;
}

TEST_F(PlaceIndexOfRooms, WithoutWallsTheModelsThatShareLevelSurfacesComeFirst) {
  const auto isLevel = [](const Eigen::Vector3d& n) { return std::abs(n.z()) > 0.98; };
  const auto withTable = [](int i) {  // tables of different heights
    return test::box({0, 0, 0}, {6, 4, 2.4}) + test::box({3.2, 1.2, 0}, {4.6, 2.8, 0.2 + 0.08 * i});
  };
  Map tables;
  tables.mounting = kMounting;
  for (int i = 0; i < 6; ++i) {
    LocalModel m;
    m.name = std::to_string(i);
    m.T_w_m = robotCamera(2, 2, 0);
    m.view = facing(viewFrom(withTable(i), *m.T_w_m, unsigned(i)), isLevel);
    ASSERT_GE(placeSignature(m.view, kMounting).surfaces.size(), 1u) << i;
    tables.models.push_back(m);
  }
  const PlaceIndex index(tables);
  for (int i = 0; i < 6; ++i) {
    const View view = facing(viewFrom(withTable(i), robotCamera(2.1, 2, 0.05), 50u + i), isLevel);
    EXPECT_EQ(index.shortlist(view, 1), std::vector<int>{i});
  }
}

// Keeps the views of a map, and perhaps its index, somewhere else.
class Store : public MapStore {
public:
  explicit Store(const Map& map, std::string index = "") : map_(map), index_(std::move(index)) {}
  std::shared_ptr<const View> view(int i) const override {
    ++asked;
    return std::make_shared<const View>(map_.models[i].view);
  }
  std::unique_ptr<std::istream> placeIndex() const override {
    return index_.empty() ? nullptr : std::make_unique<std::istringstream>(index_);
  }
  mutable std::atomic<int> asked{0};

private:
  Map map_;
  std::string index_;
};

Map kept(const Map& map, std::shared_ptr<const Store> store) {
  Map light = map;
  for (LocalModel& m : light.models) {
    m.view.segments.clear();
    const Intrinsics camera = m.view.depth.camera;
    m.view.depth = {};
    m.view.depth.camera = camera;
  }
  light.store = std::move(store);
  return light;
}

std::string written(const PlaceIndex& index) {
  std::ostringstream out;
  index.write(out);
  return out.str();
}

TEST_F(PlaceIndexOfRooms, IsTheSameAfterItWasWrittenAndRead) {
  const PlaceIndex made(*map, few());
  const std::string bytes = written(made);
  EXPECT_EQ(written(PlaceIndex(*map, few())), bytes);
  const auto store = std::make_shared<const Store>(*map, bytes);
  const Map light = kept(*map, store);
  const PlaceIndex read = PlaceIndex::of(light, few());
  EXPECT_EQ(store->asked, 0) << "no view is needed";
  EXPECT_EQ(read.models(), made.models());
  EXPECT_EQ(read.descriptors(), made.descriptors());
  EXPECT_EQ(written(read), bytes);
  for (unsigned i = 0; i < 6; ++i) {
    const View view = query(int(i % kRooms), 0.9 * i, 800 + i);
    EXPECT_EQ(read.shortlist(view, 50), made.shortlist(view, 50));
  }
}

TEST_F(PlaceIndexOfRooms, IsWrittenAndReadWithoutTemporaryFiles) {
  GTEST_FLAG_SET(death_test_style, "fast");  // in this process as it is
  const PlaceIndex index(*map);
  const auto writeAndRead = [&] {
    const rlimit nothing{0, 0};
    if (setrlimit(RLIMIT_FSIZE, &nothing) != 0) std::_Exit(2);
    std::istringstream bytes(written(index));
    std::_Exit(PlaceIndex::read(bytes, *map).has_value() ? 0 : 1);
  };
  EXPECT_EXIT(writeAndRead(), testing::ExitedWithCode(0), "");
}

TEST_F(PlaceIndexOfRooms, IsMadeAnewWhereTheWrittenOneIsForSomethingElse) {
  const std::string bytes = written(PlaceIndex(*map, few()));
  const auto reads = [&bytes](const Map& other, const PosePriorParams& prior = {}) {
    std::istringstream in(bytes);
    return PlaceIndex::read(in, other, {}, prior).has_value();
  };
  EXPECT_TRUE(reads(*map));
  Map other = *map;
  other.models.pop_back();
  EXPECT_FALSE(reads(other));
  other = *map;
  other.mounting->tilt_deg += 1;
  EXPECT_FALSE(reads(other));
  PosePriorParams prior;
  prior.floor_std *= 2;
  EXPECT_FALSE(reads(*map, prior));
  other = *map;
  std::swap(other.models[3].name, other.models[4].name);
  EXPECT_FALSE(reads(other));
  prior = {};
  prior.rotation_std_deg *= 2;  // does not matter to it
  EXPECT_TRUE(reads(*map, prior));
  EXPECT_EQ(PlaceIndex::of(kept(other, std::make_shared<const Store>(other, bytes))).models(),
            other.models.size());
  std::istringstream torn(bytes.substr(0, bytes.size() / 2));
  EXPECT_THROW(PlaceIndex::read(torn, *map), std::runtime_error);
}

TEST_F(PlaceIndexOfRooms, BytesThatTellOfMoreWallsThanThereAreAreRefused) {
  std::string bytes = written(PlaceIndex(*map, few()));
  std::array<std::int32_t, 5> facing = placeSignature(map->models[0].view, kMounting).facing;
  const auto asBytes = [&facing] {
    return std::string(reinterpret_cast<const char*>(facing.data()), sizeof facing);
  };
  const std::size_t at = bytes.find(asBytes());
  ASSERT_NE(at, std::string::npos);
  for (const std::int32_t wrong : {1000, -1}) {
    facing.back() = wrong;
    std::istringstream in(bytes.replace(at, sizeof facing, asBytes()));
    EXPECT_THROW(PlaceIndex::read(in, *map), std::runtime_error) << wrong;
  }
}

TEST_F(PlaceIndexOfRooms, BytesOfATornPictureAreRefused) {
  std::string bytes = written(PlaceIndex(*map, few()));
  const Intrinsics camera = placeSignature(map->models[0].view, kMounting).picture.camera;
  const std::string size(reinterpret_cast<const char*>(&camera), 2 * sizeof camera.width);
  const std::size_t at = bytes.find(size);
  ASSERT_NE(at, std::string::npos);
  const int wider = camera.width + 1;
  bytes.replace(at, sizeof wider, reinterpret_cast<const char*>(&wider), sizeof wider);
  std::istringstream in(bytes);
  EXPECT_THROW(PlaceIndex::read(in, *map), std::runtime_error);
}

TEST_F(PlaceIndexOfRooms, NoModelIsAskedAboutAViewThatNoneCouldPlace) {
  const auto isFloor = [](const Eigen::Vector3d& n) { return n.z() < -0.98; };
  const auto store = std::make_shared<const Store>(*map);
  GlobalLocalizationParams params;
  params.index.exhaustive_up_to = 1000000;
  const GlobalLocalization localization(std::make_shared<const Map>(kept(*map, store)), params);
  const View view = facing(query(0, 0.3, 900), isFloor);
  ASSERT_FALSE(view.segments.empty());
  EXPECT_EQ(localization.candidates(view).size(), map->models.size());
  const Localization answer = localization.localize(view);
  EXPECT_TRUE(answer.hypotheses.empty());
  EXPECT_NE(answer.reason.find("leave free"), std::string::npos) << answer.reason;
  EXPECT_EQ(store->asked, 0);
}

TEST_F(PlaceIndexOfRooms, AMapWhoseViewsAreElsewhereGivesTheSameAnswers) {
  GlobalLocalizationParams params;
  params.index.exhaustive_up_to = 0;
  const auto store = std::make_shared<const Store>(*map);
  const GlobalLocalization here(map, params), there(std::make_shared<const Map>(kept(*map, store)), params);
  for (unsigned i = 0; i < 4; ++i) {
    const View view = query(int(i % kRooms), 0.7 * i, 900 + i);
    const Localization a = here.localize(view), b = there.localize(view);
    ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
    for (std::size_t k = 0; k < a.hypotheses.size(); ++k) {
      EXPECT_EQ(a.hypotheses[k].model, b.hypotheses[k].model);
      EXPECT_EQ(a.hypotheses[k].T_w_c->matrix(), b.hypotheses[k].T_w_c->matrix());
      EXPECT_EQ(a.hypotheses[k].probability, b.hypotheses[k].probability);
    }
  }
}

TEST_F(PlaceIndexOfRooms, BadInput) {
  const PlaceIndex index(*map, few());
  EXPECT_TRUE(index.shortlist(View{}, 10).empty());
  EXPECT_TRUE(index.shortlist(map->models[0].view, 0).empty());
  View bad = map->models[0].view;
  for (Segment& s : bad.segments) s.R(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(index.shortlist(bad, 10).empty());

  Map empty;
  EXPECT_THROW(PlaceIndex{empty}, std::invalid_argument);  // no mounting
  empty.mounting = kMounting;
  EXPECT_TRUE(PlaceIndex(empty).shortlist(map->models[0].view, 10).empty());

  Map without_segments = empty;
  without_segments.models.resize(3);
  EXPECT_EQ(PlaceIndex(without_segments).shortlist(map->models[0].view, 10), (std::vector<int>{0, 1, 2}));
}

}  // namespace
}  // namespace facetloc
