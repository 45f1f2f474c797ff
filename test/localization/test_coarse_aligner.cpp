// SPDX-License-Identifier: BSD-3-Clause
#include "shortlist/coarse_aligner.h"

#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

namespace facetloc {

using namespace internal;
namespace {

constexpr CameraMounting kMounting{1.0, 10.0};

Eigen::Isometry3d robot(double x, double y, double heading) {
  return Eigen::Translation3d(x, y, 0) * Eigen::Isometry3d(expSO3({0, 0, heading}));
}

View seenFrom(const Eigen::Isometry3d& T_w_b, unsigned seed) {
  return viewFrom(test::largeRoom(), T_w_b * kMounting.T_b_c(), seed);
}

TEST(CoarseAligner, FindsTheMotionBetweenTwoViews) {
  const Eigen::Isometry3d T_w_m = robot(2, 2.5, 0.1), T_w_s = robot(2.4, 2.2, -0.15);
  const PlaceDescriptor model = placeDescriptor(seenFrom(T_w_m, 1), kMounting),
                        scene = placeDescriptor(seenFrom(T_w_s, 2), kMounting);
  const PlaceAlignment found = CoarseAligner(scene).align(model);
  const Eigen::Isometry3d T_m_s = T_w_m.inverse() * T_w_s;
  EXPECT_NEAR(found.x, T_m_s.translation().x(), 0.1);
  EXPECT_NEAR(found.y, T_m_s.translation().y(), 0.1);
  EXPECT_NEAR(found.heading, -0.25, 1.5 * kDegree);
}

TEST(CoarseAligner, StillFindsItWithHalfOfTheSegments) {
  const Eigen::Isometry3d T_w_m = robot(2, 2.5, 0.1), T_w_s = robot(2.3, 2.4, 0.0);
  View halved = seenFrom(T_w_s, 2), other_half = halved;
  halved.segments.clear();
  for (std::size_t i = 0; i < other_half.segments.size(); i += 2)
    halved.segments.push_back(other_half.segments[i]);
  const PlaceDescriptor model = placeDescriptor(seenFrom(T_w_m, 1), kMounting),
                        elsewhere = placeDescriptor(seenFrom(robot(4, 1.5, 2.4), 3), kMounting),
                        scene = placeDescriptor(halved, kMounting);
  CoarseAligner aligner(scene);
  EXPECT_GT(aligner.align(model).score, aligner.align(elsewhere).score);
}

TEST(CoarseAligner, NothingFitsNothing) {
  const PlaceDescriptor place = placeDescriptor(seenFrom(robot(2, 2.5, 0), 1), kMounting), nothing;
  EXPECT_EQ(CoarseAligner(nothing).align(place).score, PlaceAlignment{}.score);
  EXPECT_EQ(CoarseAligner(place).align(nothing).score, PlaceAlignment{}.score);
}

TEST(CoarseAligner, WithoutDepthTheWallsAloneAreLaidOverEachOther) {
  const Eigen::Isometry3d T_w_m = robot(2, 2.5, 0.1), T_w_s = robot(2.4, 2.2, -0.15);
  const PlaceDescriptor model = placeDescriptor(seenFrom(T_w_m, 1), kMounting),
                        scene = placeDescriptor(seenFrom(T_w_s, 2), kMounting);
  PlaceDescriptor flat_model = model, flat_scene = scene;
  flat_model.picture = flat_scene.picture = {};
  const float score = CoarseAligner(scene).align(model).score;
  for (const PlaceAlignment& found :
       {CoarseAligner(scene).align(flat_model), CoarseAligner(flat_scene).align(model),
        CoarseAligner(flat_scene).align(flat_model)}) {
    EXPECT_NEAR(found.heading, -0.25, 1.5 * kDegree);
    EXPECT_LT(found.score, score);
  }
}

TEST(CoarseAligner, DepthThatContradictsCosts) {
  const PlaceDescriptor scene = placeDescriptor(seenFrom(robot(2.4, 2.2, -0.15), 2), kMounting);
  PlaceDescriptor model = placeDescriptor(seenFrom(robot(2, 2.5, 0.1), 1), kMounting);
  CoarseAligner aligner(scene);
  const float score = aligner.align(model).score;
  for (std::uint16_t& mm : model.picture.depth) mm /= 2;
  EXPECT_LT(aligner.align(model).score, score - 0.3f);
}

TEST(CoarseAligner, GoodScoresAreFoundDespiteSkippedCandidates) {
  const PlaceDescriptor scene = placeDescriptor(seenFrom(robot(2.4, 2.2, -0.15), 2), kMounting);
  CoarseAligner aligner(scene);
  for (int i = 0; i < 12; ++i) {
    const PlaceDescriptor model =
        placeDescriptor(seenFrom(robot(2 + 0.1 * i, 2.5 - 0.05 * i, 0.2 * i), 10u + unsigned(i)), kMounting);
    const PlaceAlignment whole = aligner.align(model);
    for (const float below : {0.001f, 0.3f, 1.f, 3.f}) {
      const PlaceAlignment found = aligner.align(model, whole.score - below);
      EXPECT_EQ(found.score, whole.score) << i;
      EXPECT_EQ(found.heading, whole.heading) << i;
      EXPECT_EQ(found.x, whole.x) << i;
      EXPECT_EQ(found.y, whole.y) << i;
    }
    for (const float above : {0.f, 0.5f, 5.f})
      EXPECT_LE(aligner.align(model, whole.score + above).score, whole.score + above) << i;
  }
}

TEST(CoarseAligner, BuffersDoNotChangeTheAnswer) {
  const PlaceDescriptor a = placeDescriptor(seenFrom(robot(2, 2.5, 0.1), 1), kMounting),
                        b = placeDescriptor(seenFrom(robot(2.4, 2.2, -0.15), 2), kMounting),
                        c = placeDescriptor(seenFrom(robot(4, 1.5, 2.4), 3), kMounting);
  CoarseAligner used(b);
  used.align(c);
  EXPECT_EQ(used.align(a).score, CoarseAligner(b).align(a).score);
}

}  // namespace
}  // namespace facetloc
