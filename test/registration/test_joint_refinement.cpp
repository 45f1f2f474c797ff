// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/joint_refinement.h"
#include "pairs/plane_measurement.h"

#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace facetloc {
namespace {

using namespace internal;
using test::disturbed, test::gaussian, test::IsPositiveSemidefinite, test::MatrixNear, test::PoseNear,
    test::rectangle, test::Rng, test::uniform;

// A room of six surfaces around a local model, and its view from a pose of the prior.
struct Room {
  explicit Room(Rng& rng, double noise = 1) {
    prior.P = posePrior(CameraMounting{0.98, 10});
    truth = boxplus(prior.T, gaussian<6>(rng, prior.P));
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0}) {
        const Eigen::Vector3d n = side * (Eigen::Vector3d::Unit(axis) + 0.1 * gaussian<3>(rng)).normalized();
        Segment s = rectangle(2.5 * side * Eigen::Vector3d::Unit(axis) + 0.3 * gaussian<3>(rng), n, 1.5, 1,
                              uniform(rng, -3, 3), 0.01, 0.01);
        const Eigen::Matrix3d Sigma = s.Sigma_q;
        model.push_back(disturbed(s, noise * gaussian<3>(rng, Sigma)));
        const Segment part = test::anotherPart(rng, s, 0.3);
        scene.push_back(
            transformed(disturbed(part, noise * gaussian<3>(rng, part.Sigma_q)), truth.inverse()));
      }
  }
  // The first three independent directions in a sequence of Kalman updates, as the tree would emit them.
  bool sequential(Hypothesis& h) const {
    PoseWithCovariance pose = prior;
    for (const int k : {0, 2, 4}) {
      const EkfUpdate u = ekfPoseUpdate(scene[k], model[k], pose);
      if (!u.accepted) return false;
      pose = u.pose;
    }
    h.T_m_c = pose;
    return true;
  }
  bool refine(Hypothesis& h, const std::optional<TranslationConstraint>& constraint = {}) const {
    return refineJointly(scene, model, prior, {}, constraint, h);
  }
  PoseWithCovariance prior;
  Eigen::Isometry3d truth;
  std::vector<Segment> scene, model;
};

TEST(JointRefinement, RecoversThePoseOfExactSegments) {
  Rng rng(2);
  for (int i = 0; i < 50; ++i) {
    Room room(rng, 0);
    room.prior.P *= 1e8;  // or it would pull a little: it is tight in roll, pitch and height
    Hypothesis h;
    h.T_m_c.T = boxplus(room.truth, 0.02 * gaussian<6>(rng));
    h.T_m_c.P.diagonal() << 1e-3, 1e-3, 1e-3, 1e-2, 1e-2, 1e-2;
    ASSERT_TRUE(room.refine(h));
    EXPECT_THAT(h.T_m_c.T, PoseNear(room.truth, 1e-5, 1e-4));
    EXPECT_THAT(h.T_m_c.P, IsPositiveSemidefinite(1e-15));
  }
}

TEST(JointRefinement, DoesNotDependOnAnyOrder) {
  Rng rng(3);
  for (int i = 0; i < 30; ++i) {
    Room room(rng);
    Hypothesis h;
    if (!room.sequential(h)) continue;
    const Hypothesis start = h;
    ASSERT_TRUE(room.refine(h));
    std::vector<int> order(room.scene.size());
    std::iota(order.begin(), order.end(), 0);
    for (int k = 0; k < 5; ++k) {
      std::shuffle(order.begin(), order.end(), rng);
      Room shuffled = room;
      for (std::size_t j = 0; j < order.size(); ++j) shuffled.scene[j] = room.scene[order[j]];
      std::shuffle(shuffled.model.begin(), shuffled.model.end(), rng);
      Hypothesis other = start;
      ASSERT_TRUE(shuffled.refine(other));
      EXPECT_THAT(other.T_m_c.T, PoseNear(h.T_m_c.T, 1e-6, 1e-5));
      EXPECT_THAT(other.T_m_c.P, MatrixNear(h.T_m_c.P, 1e-8));
    }
  }
}

TEST(JointRefinement, DoesNotDependOnTheStart) {
  Rng rng(4);
  for (int i = 0; i < 30; ++i) {
    const Room room(rng);
    Hypothesis a, b;
    a.T_m_c.T = boxplus(room.truth, 0.01 * gaussian<6>(rng));
    b.T_m_c.T = boxplus(room.truth, 0.01 * gaussian<6>(rng));
    a.T_m_c.P.diagonal() << 1e-3, 1e-3, 1e-3, 1e-2, 1e-2, 1e-2;
    b.T_m_c.P = a.T_m_c.P;
    ASSERT_TRUE(room.refine(a) && room.refine(b));
    ASSERT_EQ(a.pairs.size(), b.pairs.size());
    EXPECT_THAT(a.T_m_c.T, PoseNear(b.T_m_c.T, 1e-5, 1e-4));
  }
}

TEST(JointRefinement, BeatsTheSequenceAndKnowsItsError) {
  Rng rng(5);
  double sequence = 0, joint = 0, nees = 0;
  int n = 0;
  for (int i = 0; i < 1600; ++i) {
    const Room room(rng);
    Hypothesis h;
    if (!room.sequential(h)) continue;
    const Vector6d before = boxminus(h.T_m_c.T, room.truth);
    if (!room.refine(h)) continue;
    const Vector6d after = boxminus(room.truth, h.T_m_c.T);
    ++n;
    sequence += before.squaredNorm();
    joint += after.squaredNorm();
    nees += after.dot(h.T_m_c.P.llt().solve(after));
  }
  EXPECT_GT(n, 1400);
  EXPECT_LT(joint, 0.5 * sequence);
  EXPECT_GE(nees / n, 4.5);
  EXPECT_LE(nees / n, 7.5);
}

TEST(JointRefinement, ItsResultIsAMinimumOfTheCost) {
  Rng rng(6);
  for (int i = 0; i < 30; ++i) {
    const Room room(rng);
    Hypothesis h;
    if (!room.sequential(h) || !room.refine(h)) continue;
    const Matrix6d prior_information = room.prior.P.inverse();
    // The weights are those of the optimum, as in any Gauss-Newton step.
    std::vector<Eigen::Matrix3d> weights;
    for (const SegmentPair& p : h.pairs) {
      PlaneMeasurement m;
      ASSERT_TRUE(measurePlane(room.scene[p.scene], room.model[p.model], h.T_m_c.T, 0, m));
      weights.push_back(m.W.inverse());
    }
    const auto cost = [&](const Eigen::Isometry3d& T) {
      const Vector6d e = boxminus(T, room.prior.T);
      double sum = e.dot(prior_information * e);
      for (std::size_t k = 0; k < h.pairs.size(); ++k) {
        PlaneMeasurement m;
        if (!measurePlane(room.scene[h.pairs[k].scene], room.model[h.pairs[k].model], T, 0, m)) continue;
        const double d2 = m.h.dot(weights[k] * m.h);
        sum += d2 <= 11.345 ? d2 : 2 * std::sqrt(11.345 * d2) - 11.345;  // Huber
      }
      return sum;
    };
    const double least = cost(h.T_m_c.T);
    const Eigen::Matrix<double, 6, 6> root = h.T_m_c.P.llt().matrixL();
    for (int k = 0; k < 20; ++k)
      EXPECT_GE(cost(boxplus(h.T_m_c.T, 0.3 * root * gaussian<6>(rng))), least - 1e-9);
  }
}

TEST(JointRefinement, AKnownPositionIsRespected) {
  // A corridor along x: floor and side walls leave x free.
  Rng rng(7);
  for (int i = 0; i < 50; ++i) {
    Room room(rng);
    room.scene.erase(room.scene.begin(), room.scene.begin() + 2);
    room.model.erase(room.model.begin(), room.model.begin() + 2);
    const Eigen::Vector3d v = (Eigen::Vector3d::UnitX() + 0.1 * gaussian<3>(rng)).normalized();
    Hypothesis h;
    h.T_m_c.T = room.truth;
    h.T_m_c.P.diagonal() << 1e-3, 1e-3, 1e-3, 1e-2, 1e-2, 1e-2;
    const double position = v.dot(room.truth.translation()) + 0.02 * gaussian<1>(rng)[0];
    Hypothesis free = h;
    ASSERT_TRUE(room.refine(free));
    ASSERT_TRUE(room.refine(h, TranslationConstraint{v, position, 0.03}));
    EXPECT_NEAR(v.dot(h.T_m_c.T.translation()), position, 0.03);
    EXPECT_LE(v.dot(h.T_m_c.P.bottomRightCorner<3, 3>() * v), 0.03 * 0.03);
    EXPECT_GT(v.dot(free.T_m_c.P.bottomRightCorner<3, 3>() * v),
              v.dot(h.T_m_c.P.bottomRightCorner<3, 3>() * v));
  }
}

TEST(JointRefinement, PartsOfOneWallCountAtMostAsTwo) {
  Rng rng(8);
  const Room room(rng);
  Hypothesis whole, parts;
  whole.T_m_c.T = parts.T_m_c.T = room.truth;
  whole.T_m_c.P.diagonal() << 1e-3, 1e-3, 1e-3, 1e-2, 1e-2, 1e-2;
  parts.T_m_c.P = whole.T_m_c.P;
  Room split = room;
  for (int k = 0; k < 9; ++k) split.scene.push_back(room.scene[0]);  // ten pieces of the first wall
  ASSERT_TRUE(room.refine(whole) && split.refine(parts));
  EXPECT_EQ(parts.pairs.size(), whole.pairs.size() + 9);
  PlaneMeasurement m;
  ASSERT_TRUE(measurePlane(room.scene[0], room.model[0], whole.T_m_c.T, 0, m));
  const Matrix6d of_one = m.H.transpose() * m.W.inverse() * m.H;
  const Matrix6d added = parts.T_m_c.P.inverse() - whole.T_m_c.P.inverse();
  EXPECT_LT(added.trace(), 1.1 * of_one.trace());
  EXPECT_GT(added.trace(), 0.9 * of_one.trace());
}

TEST(JointRefinement, WithoutAPairChangesNothing) {
  Rng rng(9);
  const Room room(rng);
  Hypothesis h;
  h.T_m_c.T = boxplus(room.truth, (Vector6d() << 0, 0, 0, 20, 20, 20).finished());
  h.T_m_c.P = 1e-6 * Matrix6d::Identity();
  h.pairs = {{1, 2, 3}};
  const Hypothesis before = h;
  EXPECT_FALSE(room.refine(h));
  EXPECT_FALSE(refineJointly({}, room.model, room.prior, {}, {}, h));
  EXPECT_FALSE(refineJointly(room.scene, {}, room.prior, {}, {}, h));
  EXPECT_EQ(h.T_m_c.T.matrix(), before.T_m_c.T.matrix());
  EXPECT_EQ(h.T_m_c.P, before.T_m_c.P);
  EXPECT_EQ(h.pairs.size(), 1u);
}

}  // namespace
}  // namespace facetloc
