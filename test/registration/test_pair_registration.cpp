// SPDX-License-Identifier: BSD-3-Clause
#include "ranking/global_localization.h"

#include <facetloc/registration/candidate_pairs.h>
#include <facetloc/registration/pair_registration.h>
#include <facetloc/testing/map_of_view.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gmock/gmock.h>

#include <limits>
#include <memory>
#include <vector>

namespace facetloc {
namespace {

using test::lookingAlong, test::PoseNear, test::viewFrom, testing::HasSubstr;

const Eigen::Isometry3d kTarget = lookingAlong({3, 2.5, 1.2}, {1, 0.4, -0.2});
const Eigen::Isometry3d kNear = lookingAlong({2.8, 2.4, 1.25}, {1, 0.3, -0.25});

View viewOf(const Eigen::Isometry3d& T_w_c, unsigned seed) {
  return viewFrom(test::largeRoom(), T_w_c, seed);
}

PoseWithCovariance usualPrior() { return {Eigen::Isometry3d::Identity(), posePrior({})}; }

TEST(PairRegistration, FindsTheTruePoseOfOneViewInAnother) {
  const PairRegistration registration(viewOf(kTarget, 1));
  const Localization answer = registration.align(viewOf(kNear, 2));
  ASSERT_FALSE(answer.hypotheses.empty()) << answer.reason;
  EXPECT_THAT(answer.hypotheses.front().T_m_c.T, PoseNear(kTarget.inverse() * kNear, 0.03, 1));
  EXPECT_THAT(*answer.hypotheses.front().T_w_c, PoseNear(answer.hypotheses.front().T_m_c.T, 1e-12, 1e-9));
  EXPECT_GT(answer.hypotheses.front().probability, 0.5);
}

/** The independent truth: a map of one local model whose pose is the identity. Pairs count their pixels
 * alone, too (METHOD 10.6), which may add to a score and never takes from it. */
TEST(PairRegistration, AnswersAsAMapOfOneLocalModel) {
  const View target = viewOf(kTarget, 1), view = viewOf(kNear, 2);
  const Localization of_pair = PairRegistration(target).align(view, usualPrior());
  const internal::GlobalLocalization map(std::make_shared<const Map>(test::mapOf(target)));
  const Localization of_map = map.localize(view);
  ASSERT_EQ(of_pair.hypotheses.size(), of_map.hypotheses.size());
  for (std::size_t i = 0; i < of_map.hypotheses.size(); ++i) {
    const Hypothesis &a = of_pair.hypotheses[i], &b = of_map.hypotheses[i];
    EXPECT_EQ(a.T_m_c.T.matrix(), b.T_m_c.T.matrix());
    EXPECT_EQ(a.T_m_c.P, b.T_m_c.P);
    EXPECT_EQ(a.evidence, b.evidence);
    EXPECT_GE(a.score, b.score);
  }
  ASSERT_FALSE(of_map.hypotheses.empty());
  EXPECT_GE(of_pair.hypotheses.front().probability, of_map.hypotheses.front().probability);
}

TEST(PairRegistration, TakesChosenPairsOnly) {
  const View target = viewOf(kTarget, 1), view = viewOf(kNear, 2);
  const PairRegistration registration(target);
  const std::vector<SegmentPair> all = candidatePairs(view.segments, target.segments, usualPrior());
  const Localization free = registration.align(view, usualPrior());
  const Localization same = registration.align(view, usualPrior(), &all);
  ASSERT_FALSE(free.hypotheses.empty());
  ASSERT_FALSE(same.hypotheses.empty());
  EXPECT_THAT(same.hypotheses[0].T_m_c.T, PoseNear(free.hypotheses[0].T_m_c.T, 1e-6, 1e-4));

  const std::vector<SegmentPair> none;
  EXPECT_TRUE(registration.align(view, usualPrior(), &none).hypotheses.empty());
  for (const SegmentPair& wrong : {SegmentPair{-1, 0}, {0, -1}, {1000, 0}, {0, 1000}}) {
    const std::vector<SegmentPair> pairs = {wrong};
    EXPECT_THROW(registration.align(view, usualPrior(), &pairs), std::invalid_argument);
  }
}

TEST(PairRegistration, GivesReasonsWhereItHasNoPose) {
  const PairRegistration registration(viewOf(kTarget, 1));
  EXPECT_THAT(registration.align(View()).reason, HasSubstr("no planar segment"));
  PoseWithCovariance prior = usualPrior();
  prior.P(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(registration.align(viewOf(kNear, 2), prior).reason, HasSubstr("not positive definite"));
  EXPECT_THAT(PairRegistration(View()).align(viewOf(kNear, 2)).reason, HasSubstr("no local model agrees"));
}

TEST(PairRegistration, RefusesParametersOutOfTheirRange) {
  RegistrationParams params;
  params.evidence.hypotheses = -1;
  EXPECT_THROW(PairRegistration(View(), params), std::invalid_argument);
}

}  // namespace
}  // namespace facetloc
