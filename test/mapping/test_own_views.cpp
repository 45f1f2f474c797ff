// SPDX-License-Identifier: BSD-3-Clause
#include "poses/pose_fusion.h"
#include "ranking/global_localization.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/mapping/map_session.h>
#include <facetloc/testing/synthetic_views.h>

#include <gmock/gmock.h>

#include <memory>

namespace facetloc {
namespace {

using test::largeRoom, test::lookingAlong, test::onCircle, test::viewFrom;

constexpr int kAround = 18, kLone = kAround, kRendered = kAround + 1, kTwin = 3;

LocalModel modelOf(const test::Scene& scene, const Eigen::Isometry3d& T_w_m, int number) {
  View view = viewFrom(scene, T_w_m, 1000 + static_cast<unsigned>(number));
  view.camera.reset();
  return {"image" + std::to_string(number), double(number), T_w_m, std::move(view)};
}

/** The large room by images all around its middle, an image of another room that nothing else shows, and a
 * rendered view that is equal to one of the images. */
std::shared_ptr<const Map> mapOfRoom() {
  static const auto map = [] {
    auto made = std::make_shared<Map>();
    for (int i = 0; i < kAround; ++i) made->models.push_back(modelOf(largeRoom(), onCircle(20 * i, 0.35), i));
    const Eigen::Isometry3d T_w_m = lookingAlong({1, 1, 1.3}, {1, 1.2, -0.3});
    LocalModel lone = modelOf(test::furnishedRoom(), T_w_m, kLone);
    lone.T_w_m = Eigen::Translation3d(40, 0, 0) * T_w_m;
    made->models.push_back(lone);
    LocalModel rendered = made->models[kTwin];
    rendered.name = "rendered";
    made->models.push_back(rendered);
    made->meta[kRenderedKey] = "rendered\n";
    return made;
  }();
  return map;
}

const std::vector<OwnView>& answers() {
  static const std::vector<OwnView> views = localizeOwnViews(mapOfRoom(), {}, {}, 2);
  return views;
}

TEST(OwnViews, AreRightAndSureWhereNeighboursShowTheSame) {
  ASSERT_EQ(answers().size(), std::size_t{kAround + 1}) << "rendered views are not asked";
  int right = 0, sure = 0, inside = 0;
  for (int i = 0; i < kAround; ++i) {
    const OwnView& view = answers()[i];
    EXPECT_EQ(view.model, i);
    EXPECT_EQ(view.right, view.nees.has_value());
    EXPECT_TRUE(view.right || view.state != AnswerState::sure) << i;
    EXPECT_FALSE(view.right && view.mistaken_for) << i;
    right += view.right, sure += view.isSureAndRight(), inside += view.isInside();
  }
  EXPECT_GE(right, 14);
  EXPECT_GE(sure, 7);
  EXPECT_GE(4 * inside, 3 * right);
}

TEST(OwnViews, AreUnknownWhereNothingElseShowsTheSame) {
  const OwnView& lone = answers().back();
  EXPECT_EQ(lone.model, kLone);
  EXPECT_EQ(lone.state, AnswerState::unknown);
  EXPECT_STREQ(lone.verdict(), "unknown");
  EXPECT_FALSE(lone.right || lone.nees || lone.isAlias());
  EXPECT_FALSE(lone.reason.empty());
  if (lone.mistaken_for) {
    EXPECT_LT(*lone.mistaken_for, kAround);
    EXPECT_GT(lone.distance, 20);
  }
}

/** An image finds no place, and gives no evidence of one: it is not even in the map. */
TEST(OwnViews, AreAnsweredAsInAMapWithoutThem) {
  Map rest = *mapOfRoom();
  rest.meta.clear();
  rest.models.erase(rest.models.begin() + kRendered);
  rest.models.erase(rest.models.begin() + kTwin);
  View view = *mapOfRoom()->view(kTwin);
  view.camera = std::make_shared<const Camera>(rest.camera);
  const Localization truth = internal::GlobalLocalization(std::make_shared<const Map>(rest)).localize(view);
  ASSERT_FALSE(truth.hypotheses.empty());
  const Hypothesis& first = truth.hypotheses.front();
  const OwnView& own = answers()[kTwin];
  EXPECT_EQ(own.state, truth.state);
  EXPECT_NEAR(own.probability, first.probability, 1e-9);
  ASSERT_TRUE(own.right);
  PoseWithCovariance T_w_c = *rest.models[first.model].T_w_m * first.T_m_c;
  const ConsideredErrors of_stored = consideredErrorsOf(rest);
  T_w_c.P = internal::withSharedErrors(T_w_c.P, of_stored.rotation_std, of_stored.translation_std);
  EXPECT_NEAR(*own.nees, squaredMahalanobis(T_w_c, *mapOfRoom()->models[kTwin].T_w_m), 1e-6);
}

TEST(OwnViews, AreTheSameForAnyNumberOfThreadsAndReportProgress) {
  std::size_t done = 0;
  const std::vector<OwnView> one = localizeOwnViews(mapOfRoom(), {}, {}, 1, [&](const MapProgress& at) {
    EXPECT_EQ(at.stage, MapProgress::Stage::own_views);
    EXPECT_EQ(at.total, answers().size());
    done = at.done;
  });
  EXPECT_EQ(done, answers().size());
  ASSERT_EQ(one.size(), answers().size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    const OwnView &a = one[i], &b = answers()[i];
    EXPECT_EQ(a.model, b.model);
    EXPECT_EQ(a.state, b.state);
    EXPECT_EQ(a.probability, b.probability);
    EXPECT_EQ(a.nees, b.nees);
    EXPECT_EQ(a.mistaken_for, b.mistaken_for);
    EXPECT_EQ(a.distance, b.distance);
    EXPECT_EQ(a.free_motions, b.free_motions);
    EXPECT_EQ(a.reason, b.reason);
  }
}

TEST(OwnViews, NameTheMotionsThatTheyLeaveFree) {
  Map map;
  for (const double y : {0.0, 2.0, 4.0})
    map.models.push_back(modelOf(test::endlessCorridor(), test::alongCorridor(y), static_cast<int>(y)));
  for (const OwnView& view : localizeOwnViews(std::make_shared<const Map>(map))) {
    EXPECT_FALSE(view.isSureAndRight());
    EXPECT_THAT(view.free_motions, testing::HasSubstr("translation along (0.00, 1.00, 0.00)"));
  }
}

TEST(OwnViews, CalibrateWithTheirProbabilities) {
  SureCalibration of_map(0.3, 0.5), of_answers(0.3, 0.5);
  addOwnViews(mapOfRoom(), of_map);
  for (const OwnView& view : answers()) of_answers.add(view.probability, view.right);
  EXPECT_EQ(of_map.images(), answers().size());
  EXPECT_EQ(of_map.threshold(), of_answers.threshold());
}

TEST(OwnViews, OfAMapWithoutPosesAreNone) {
  Map unposed = *mapOfRoom();
  for (LocalModel& model : unposed.models) model.T_w_m.reset();
  EXPECT_TRUE(localizeOwnViews(std::make_shared<const Map>(unposed)).empty());
  EXPECT_TRUE(localizeOwnViews(std::make_shared<const Map>()).empty());
}

}  // namespace
}  // namespace facetloc
