// SPDX-License-Identifier: BSD-3-Clause
#include "shortlist/coarse_aligner.h"

#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

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

PlaceDescriptor placeAt(double x, double y, double heading, unsigned seed) {
  return placeDescriptor(seenFrom(robot(x, y, heading), seed), kMounting);
}

// Views of the room all around, some of them from one place.
std::vector<PlaceDescriptor> somePlaces() {
  std::vector<PlaceDescriptor> places;
  for (unsigned i = 0; i < 12; ++i)
    places.push_back(placeAt(1.8 + 0.2 * (i % 5), 2.1 + 0.15 * (i % 4), 0.7 * i, 10 + i));
  return places;
}

int quarters(float turn) { return static_cast<int>(std::lround(turn / (90 * kDegree))); }

// The same in the plainest way: all turns, all pairs of walls, all moves.
double outlookByHand(const PlaceDescriptor& scene, const PlaceDescriptor& model) {
  const auto facesMain = [](const PlaceDescriptor& place, const Wall& w) {
    const double turn = std::remainder(w.heading - place.main_heading, 90 * kDegree);
    return std::abs(turn) <= 8 * kDegree;
  };
  double best = 0;
  for (int q = 0; q < 4; ++q) {
    const double turn =
        std::remainder(model.main_heading - scene.main_heading + q * 90 * kDegree, 360 * kDegree);
    if (std::abs(turn) > 60 * kDegree) continue;
    std::map<long, double> votes[2];  // keyed by the move in twentieths of a metre, along x and along y
    for (const Wall& m : model.walls)
      for (const Wall& s : scene.walls) {
        if (!facesMain(model, m) || !facesMain(scene, s)) continue;
        const int faces = quarters(m.heading - model.main_heading);
        if ((quarters(s.heading - scene.main_heading) + q - faces) % 4 != 0) continue;
        if (s.bottom - m.top > 0.05 || m.bottom - s.top > 0.05) continue;
        // Unit vectors of the wall's normal and of its extent, in the model's main directions.
        const int normal_axis = faces & 1, normal_sign = (faces & 2) ? -1 : 1;
        const int along_axis = 1 - normal_axis, along_sign = ((faces + 1) & 2) ? -1 : 1;
        const double weight = std::min(m.weight, s.weight);
        double edges = 0;
        if (s.top_end && m.top_end && std::abs(s.top - m.top) < 0.06) edges += 1.5;
        if (s.bottom_end && m.bottom_end && std::abs(s.bottom - m.bottom) < 0.06) edges += 1.5;
        const auto vote = [&](int axis, int sign, double move, double worth) {
          const long step = std::lround(sign * move / 0.05);
          if (-56 <= step && step < 56) votes[axis][step] += worth;
        };
        vote(normal_axis, normal_sign, m.offset - s.offset, weight * (1 + edges));
        if (s.right_end && m.right_end) vote(along_axis, along_sign, m.right - s.right, weight);
        if (s.left_end && m.left_end) vote(along_axis, along_sign, m.left - s.left, weight);
      }
    double sum = 0;
    for (std::map<long, double>& v : votes) {
      double most = 0;
      for (long step = -56; step < 56; ++step) {
        const double move = 0.05 * static_cast<double>(step);
        most = std::max(most, v[step] + 0.5 * (v[step - 1] + v[step + 1]) - 0.4 * move * move);
      }
      sum += most;
    }
    best = std::max(best, sum - 1.5 * turn * turn);
  }
  for (const LevelSurface& a : scene.surfaces)
    for (const LevelSurface& b : model.surfaces)
      if (a.from_below == b.from_below && std::abs(a.height - b.height) < 0.05) {
        best += 2;
        break;
      }
  double total = 2;
  for (const Wall& w : model.walls) total += w.weight;
  return best / std::pow(total, 0.6);
}

TEST(Prescore, EqualsTheMaximumOverAllTurnsPairsAndMoves) {
  const std::vector<PlaceDescriptor> places = somePlaces();
  for (const PlaceDescriptor& scene : places) {
    const Prescore outlook(scene);
    for (const PlaceDescriptor& model : places)
      EXPECT_NEAR(outlook.of(model), outlookByHand(scene, model), 1e-3);
  }
}

TEST(Prescore, IsBestForAPlaceThatIsNear) {
  const PlaceDescriptor scene = placeAt(2.2, 2.3, 0.2, 1), near = placeAt(2, 2.5, 0.1, 2);
  const Prescore outlook(scene);
  EXPECT_GT(outlook.of(scene), outlook.of(near));
  for (const double heading : {1.3, 2.4, -1.5, -2.5})
    EXPECT_GT(outlook.of(near), 1.5f * outlook.of(placeAt(4, 1.5, heading, 3))) << heading;
}

TEST(Prescore, IsStillBestWithHalfOfTheWalls) {
  PlaceDescriptor scene = placeAt(2.2, 2.3, 0.2, 1);
  for (int k = 0; k < 4; ++k) {
    const auto first = scene.walls.begin() + scene.facing[k];
    const int half = (scene.facing[k + 1] - scene.facing[k]) / 2;
    scene.walls.erase(first, first + half);
    for (int later = k + 1; later < 5; ++later) scene.facing[later] -= half;
  }
  const Prescore outlook(scene);
  EXPECT_GT(outlook.of(placeAt(2, 2.5, 0.1, 2)), outlook.of(placeAt(4, 1.5, 2.4, 3)));
}

TEST(Prescore, IsZeroForAnEmptyView) {
  const PlaceDescriptor place = placeAt(2, 2.5, 0, 1), nothing;
  EXPECT_EQ(Prescore(nothing).of(place), 0);
  EXPECT_EQ(Prescore(place).of(nothing), 0);
}

TEST(Prescore, ManyWallsThatFaceOneWayAreAllCompared) {
  // More than fit into a vector; each at its own height, so that it fits only itself.
  PlaceDescriptor stairs;
  for (int i = 0; i < 20; ++i) {
    Wall w;
    w.offset = 1 + 0.3f * static_cast<float>(i);
    w.bottom = 0.1f * static_cast<float>(i);
    w.top = w.bottom + 0.04f, w.weight = 0.5f;
    stairs.walls.push_back(w);
  }
  stairs.facing = {0, 20, 20, 20, 20};
  EXPECT_NEAR(Prescore(stairs).of(stairs), 10 / std::pow(2 + 10, 0.6), 1e-4);
  EXPECT_NEAR(Prescore(stairs).of(stairs), outlookByHand(stairs, stairs), 1e-4);
}

}  // namespace
}  // namespace facetloc
