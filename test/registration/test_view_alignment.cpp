// SPDX-License-Identifier: BSD-3-Clause
#include "nearby/view_alignment.h"

#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {
namespace {

using namespace internal;
using test::largeRoom, test::lookingAlong, test::PoseNear, test::viewFrom;

ViewAlignmentParams usual() {
  ViewAlignmentParams params;
  params.dense.correlated_pixels = 200;
  return params;
}

Matrix6d priorCovariance(double rotation_deg, double translation) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(std::pow(rotation_deg * kDegree, 2)),
      Eigen::Vector3d::Constant(translation * translation);
  return variance.asDiagonal();
}

/** Standard deviations of a pose as a whole. */
double rotationStd(const Matrix6d& P) { return std::sqrt(P.topLeftCorner<3, 3>().trace()); }
double translationStd(const Matrix6d& P) { return std::sqrt(P.bottomRightCorner<3, 3>().trace()); }

/** Within three of them, which a Gaussian error exceeds in less than 0.3 % of all cases. */
auto isWithinItsError(const Eigen::Isometry3d& truth, const Matrix6d& P) {
  return PoseNear(truth, 3 * translationStd(P), 3 * rotationStd(P) / kDegree);
}

class AlignmentOfAView : public testing::Test {
protected:
  AlignmentOfAView() {
    for (int i = 0; i < 2; ++i) around.add(i, unowned(others[i]), poses[i]);
  }
  const std::vector<Eigen::Isometry3d> poses = {lookingAlong({2.4, 1.5, 1.2}, {0.9, 1, -0.3}),
                                                lookingAlong({2.9, 1.3, 1.2}, {0.7, 1, -0.3})};
  const std::vector<View> others = {viewFrom(largeRoom(), poses[0], 10), viewFrom(largeRoom(), poses[1], 11)};
  const Eigen::Isometry3d truth = lookingAlong({2.6, 1.7, 1.25}, {0.8, 1, -0.25});
  LocalMap around;
};

TEST_F(AlignmentOfAView, FindsTheTruthAndDoesNotBoast) {
  test::Rng rng(3);
  const Matrix6d P = priorCovariance(1, 0.03);
  double nees = 0;
  constexpr int kTrials = 10;
  for (int i = 0; i < kTrials; ++i) {
    const View view = viewFrom(largeRoom(), truth, static_cast<unsigned>(100 + i));
    const PoseWithCovariance prior{boxplus(truth, test::gaussian<6>(rng, P)), P};
    const ViewAlignment found = alignView(view, around, prior, usual());
    EXPECT_TRUE(found.dense);
    EXPECT_FALSE(found.pairs.empty());
    EXPECT_THAT(found.T_w_c.T, isWithinItsError(truth, found.T_w_c.P));
    EXPECT_LT(translationStd(found.T_w_c.P), translationStd(P) / 3);
    EXPECT_LT(rotationStd(found.T_w_c.P), rotationStd(P) / 3);
    EXPECT_LT(found.T_w_c.P.trace(), 0.2 * P.trace());
    const Vector6d e = boxminus(truth, found.T_w_c.T);
    nees += e.dot(found.T_w_c.P.ldlt().solve(e)) / kTrials;
  }
  EXPECT_LT(nees, 8.84);  // 99 % quantile of the mean of 10 draws with 6 degrees of freedom
}

TEST_F(AlignmentOfAView, WithoutPlanesUsesThePixels) {
  View view = viewFrom(largeRoom(), truth, 1);
  view.segments.clear();
  const Matrix6d P = priorCovariance(0.5, 0.04);
  PoseWithCovariance prior{truth, P};
  prior.T.translation() += Eigen::Vector3d(0.02, -0.02, 0.01);
  const ViewAlignment found = alignView(view, around, prior, usual());
  EXPECT_TRUE(found.pairs.empty());
  EXPECT_TRUE(found.dense);
  EXPECT_THAT(found.T_w_c.T, isWithinItsError(truth, found.T_w_c.P));
  EXPECT_LT(translationStd(found.T_w_c.P), 0.5 * translationStd(P));
}

TEST_F(AlignmentOfAView, WithoutAnythingInCommonIsThePrior) {
  const PoseWithCovariance prior{truth, priorCovariance(1, 0.03)};
  for (const View& view : {View(), viewFrom(largeRoom(), truth, 1)}) {
    const ViewAlignment found = alignView(view, {}, prior, usual());
    EXPECT_FALSE(found.dense);
    EXPECT_TRUE(found.pairs.empty());
    EXPECT_EQ(found.T_w_c.T.matrix(), prior.T.matrix());
    EXPECT_EQ(found.T_w_c.P, prior.P);
  }
}

TEST(AlignmentInACorridor, LeavesFreeMotionsFree) {
  const Eigen::Isometry3d other = lookingAlong({0, -0.2, 1.2}, {0, 1, -0.15}),
                          truth = lookingAlong({0.1, 0, 1.2}, {0.05, 1, -0.15});
  const View of_other = viewFrom(test::endlessCorridor(), other, 1, 6),
             view = viewFrom(test::endlessCorridor(), truth, 2, 6);
  LocalMap around;
  around.add(0, unowned(of_other), other);
  PoseWithCovariance prior{truth, priorCovariance(1, 0.05)};
  prior.T.translation() += Eigen::Vector3d(0.03, 0.04, -0.02);
  ViewAlignmentParams params = usual();
  params.dense.significance = 4;
  const ViewAlignment found = alignView(view, around, prior, params);
  EXPECT_GT(found.T_w_c.P(4, 4), 0.8 * prior.P(4, 4));
  EXPECT_NEAR(found.T_w_c.T.translation().y(), prior.T.translation().y(), 0.02);
  EXPECT_NEAR(found.T_w_c.T.translation().x(), truth.translation().x(), 0.01);
  EXPECT_NEAR(found.T_w_c.T.translation().z(), truth.translation().z(), 0.01);
}

TEST_F(AlignmentOfAView, DepthConfirmsTheRightPoseAndContradictsAWrongOne) {
  const View view = viewFrom(largeRoom(), truth, 9);
  const DepthComparison comparison({});
  const DepthAgreement right = compareWithAll(view.depth, truth, around.pictures, comparison, kFineColumns);
  EXPECT_GT(right.agree, 0.97 * right.judged());
  Eigen::Isometry3d wrong = truth;
  wrong.translation() -= Eigen::Vector3d(0.4, 0.4, 0);
  const DepthAgreement away = compareWithAll(view.depth, wrong, around.pictures, comparison, kFineColumns);
  EXPECT_LT(away.agree, 0.7 * away.judged());
  EXPECT_EQ(compareWithAll(view.depth, truth, {}, comparison, kFineColumns).judged(), 0);
  EXPECT_EQ(compareWithAll({}, truth, around.pictures, comparison, kFineColumns).judged(), 0);
}

TEST(ViewDistance, CountsMetresAndAngles) {
  const Eigen::Isometry3d a = lookingAlong({0, 0, 1}, {1, 0, 0});
  EXPECT_NEAR(viewDistance(a, lookingAlong({0, 2, 1}, {1, 0, 0})), 2, 1e-12);
  EXPECT_NEAR(viewDistance(a, lookingAlong({0, 0, 1}, {1, 1, 0})), 1.5 * 45 * kDegree, 1e-9);
  EXPECT_TRUE(std::isinf(viewDistance(a, lookingAlong({0, 0, 1}, {-1, 0, 0}))));
  EXPECT_TRUE(std::isinf(viewDistance(a, lookingAlong({0, 9, 1}, {1, 0, 0}))));
}

}  // namespace
}  // namespace facetloc
