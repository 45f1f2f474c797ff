// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/cholesky3.h"
#include "pairs/plane_measurement.h"

#include <facetloc/testing/numeric_jacobian.h>
#include <facetloc/testing/plane_residual.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace facetloc {
namespace {

using namespace internal;
using test::disturbed, test::gaussian, test::IsPositiveSemidefinite, test::MatrixNear, test::numericJacobian,
    test::randomPose, test::randomSegment, test::residualOfThePaper, test::Rng, test::uniform;

constexpr double kAnyCosine = -2;

Eigen::Vector3d smallDisturbance(Rng& rng) {
  return {uniform(rng, -0.3, 0.3), uniform(rng, -0.3, 0.3), uniform(rng, -0.3, 0.3)};
}

// A model segment, a pose, and the same surface as the camera sees it: another part of it, in other axes.
struct TruePair {
  explicit TruePair(Rng& rng) : model(randomSegment(rng)), T_m_c(randomPose(rng, 0.6, 1.0)) {
    const Segment part = test::anotherPart(rng, model, 0.5);
    scene = transformed(part, T_m_c.inverse());
  }
  Segment model;
  Eigen::Isometry3d T_m_c;
  Segment scene;
};

Matrix6d randomPoseCovariance(Rng& rng) {
  Vector6d std;
  std << 0.1, 0.2, 0.15, 0.5, 0.8, 0.3;
  return test::randomCovariance<6>(rng, std);
}

TEST(PlaneMeasurement, ATruePairUnderTheTruePoseHasNoResidual) {
  Rng rng(2);
  for (int i = 0; i < 500; ++i) {
    const TruePair pair(rng);
    PlaneMeasurement m;
    ASSERT_TRUE(measurePlane(pair.scene, pair.model, pair.T_m_c, 0, m));
    EXPECT_LT(m.h.norm(), 1e-12);
  }
}

TEST(PlaneMeasurement, ThirdComponentIsTheDistanceOfTheModelsCentroidFromTheScenesPlane) {
  Rng rng(5);
  for (int i = 0; i < 100; ++i) {
    const Segment F = randomSegment(rng), Fp = randomSegment(rng);
    const Eigen::Isometry3d T = randomPose(rng, 3.1, 3);
    const Segment moved = transformed(F, T);
    PlaneMeasurement m;
    ASSERT_TRUE(measurePlane(F, Fp, T, kAnyCosine, m));
    EXPECT_NEAR(m.h[2], moved.offset() - moved.normal().dot(Fp.t), 1e-12);
  }
}

TEST(PlaneMeasurement, IsTheEquationOfThePaperForUndisturbedPlanesWithItsDerivatives) {
  Rng rng(6);
  int measured = 0;
  for (int i = 0; i < 500; ++i) {
    const Segment F = randomSegment(rng), Fp = randomSegment(rng);
    const Eigen::Isometry3d T = randomPose(rng, 1.5, 3);
    PlaneMeasurement m;
    const double cosine = (T.linear() * F.normal()).dot(Fp.normal());
    ASSERT_EQ(measurePlane(F, Fp, T, 0.3, m), cosine > 0.3);
    if (!(cosine > 0.3)) continue;
    ++measured;
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    EXPECT_THAT(m.h, MatrixNear(residualOfThePaper(F, Fp, T, zero, zero), 1e-12));
    const auto H = numericJacobian<3, 6>(
        [&](const Vector6d& d) { return residualOfThePaper(F, Fp, boxplus(T, d), zero, zero); },
        Vector6d::Zero().eval());
    const auto E = numericJacobian<3, 3>(
        [&](const Eigen::Vector3d& q) { return residualOfThePaper(F, Fp, T, q, zero); }, zero);
    const auto E_model = numericJacobian<3, 3>(
        [&](const Eigen::Vector3d& qp) { return residualOfThePaper(F, Fp, T, zero, qp); }, zero);
    EXPECT_THAT(m.H, MatrixNear(H, 1e-7));
    const Eigen::Matrix3d W = E * F.Sigma_q * E.transpose() + E_model * Fp.Sigma_q * E_model.transpose();
    EXPECT_THAT(m.W, MatrixNear(W, 1e-6));
    EXPECT_THAT(m.W, IsPositiveSemidefinite(1e-12));
    const Matrix6d P = randomPoseCovariance(rng);
    const Eigen::Matrix3d S = m.H * P * m.H.transpose() + m.W;
    EXPECT_NEAR(innovationDistance(m, P), m.h.dot(S.inverse() * m.h), 1e-9 * (1 + innovationDistance(m, P)));
  }
  EXPECT_GT(measured, 100);
}

TEST(PlaneMeasurement, DistanceOfTheOffsetAloneIsNeverLarger) {
  Rng rng(13);
  for (int i = 0; i < 500; ++i) {
    TruePair pair(rng);
    pair.scene = disturbed(pair.scene, 0.1 * smallDisturbance(rng));
    const PoseWithCovariance pose{pair.T_m_c, randomPoseCovariance(rng)};
    PlaneMeasurement m;
    ASSERT_TRUE(measurePlane(pair.scene, pair.model, pose.T, 0, m));
    const double variance = (m.H * pose.P * m.H.transpose() + m.W)(2, 2), want = m.h[2] * m.h[2] / variance;
    EXPECT_NEAR(offsetDistance(pair.scene, pair.model, pose), want, 1e-9 * (1 + want));
    EXPECT_NEAR(offsetDistance(pair.scene, pair.model, pose, 0.05), m.h[2] * m.h[2] / (variance + 0.0025),
                1e-9 * (1 + want));
    EXPECT_LE(want, innovationDistance(m, pose.P) * (1 + 1e-9));
  }
}

TEST(PlaneMeasurement, OppositeNormalsAreNoMeasurement) {
  Rng rng(7);
  const TruePair pair(rng);
  Segment flipped = pair.scene;
  flipped.R.col(1) *= -1;
  flipped.R.col(2) *= -1;  // the wall seen from its other side: h would be zero
  PlaneMeasurement m;
  EXPECT_TRUE(measurePlane(pair.scene, pair.model, pair.T_m_c, 0, m));
  EXPECT_FALSE(measurePlane(flipped, pair.model, pair.T_m_c, 0, m));
}

TEST(PlaneMeasurement, SlopeNoiseIsLeveredByTheDistanceOfTheCentroids) {
  Rng rng(8);
  const TruePair pair(rng);
  Segment far = pair.model;
  far.t += 3 * far.R.col(0);
  PlaneMeasurement near_m, far_m;
  ASSERT_TRUE(measurePlane(pair.scene, pair.model, pair.T_m_c, 0, near_m));
  ASSERT_TRUE(measurePlane(pair.scene, far, pair.T_m_c, 0, far_m));
  EXPECT_GT(far_m.W(2, 2), near_m.W(2, 2));
}

TEST(PlaneMeasurement, DistanceDoesNotChangeUnderInPlaneRotations) {
  Rng rng(9);
  for (int i = 0; i < 200; ++i) {
    TruePair pair(rng);
    pair.scene = disturbed(pair.scene, 0.05 * smallDisturbance(rng));
    const Matrix6d P = randomPoseCovariance(rng);
    PlaneMeasurement m, turned_scene, turned_model;
    ASSERT_TRUE(measurePlane(pair.scene, pair.model, pair.T_m_c, 0, m));
    const double d2 = innovationDistance(m, P), angle = uniform(rng, -3, 3);
    ASSERT_TRUE(
        measurePlane(test::movedInPlane(pair.scene, 0, 0, angle), pair.model, pair.T_m_c, 0, turned_scene));
    ASSERT_TRUE(
        measurePlane(pair.scene, test::movedInPlane(pair.model, 0, 0, angle), pair.T_m_c, 0, turned_model));
    EXPECT_NEAR(turned_scene.h[2], m.h[2], 1e-12);
    EXPECT_NEAR(turned_model.h[2], m.h[2], 1e-12);
    EXPECT_NEAR(innovationDistance(turned_scene, P), d2, 1e-9 * (1 + d2));
    EXPECT_NEAR(innovationDistance(turned_model, P), d2, 1e-9 * (1 + d2));
  }
}

TEST(PlaneMeasurement, DistanceDoesNotChangeWithTheFrameOfTheModel) {
  Rng rng(10);
  for (int i = 0; i < 200; ++i) {
    TruePair pair(rng);
    pair.scene = disturbed(pair.scene, 0.05 * smallDisturbance(rng));
    const Matrix6d P = randomPoseCovariance(rng);
    const Eigen::Isometry3d X = randomPose(rng, 3, 5);
    Matrix6d A = Matrix6d::Zero();
    A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = X.linear();
    PlaneMeasurement m, moved;
    ASSERT_TRUE(measurePlane(pair.scene, pair.model, pair.T_m_c, 0, m));
    ASSERT_TRUE(measurePlane(pair.scene, transformed(pair.model, X), X * pair.T_m_c, 0, moved));
    EXPECT_THAT(moved.h, MatrixNear(m.h, 1e-12));
    const double d2 = innovationDistance(m, P);
    EXPECT_NEAR(innovationDistance(moved, A * P * A.transpose()), d2, 1e-9 * (1 + d2));
  }
}

TEST(PlaneMeasurement, SwappingSceneAndModelGivesTheSameDistanceToFirstOrder) {
  Rng rng(11);
  double worst = 0;
  for (int i = 0; i < 200; ++i) {
    TruePair pair(rng);
    pair.scene = disturbed(pair.scene, 1e-3 * smallDisturbance(rng));
    Vector6d std;
    std << 1e-3, 2e-3, 1e-3, 5e-3, 5e-3, 5e-3;
    const Matrix6d P = test::randomCovariance<6>(rng, std);
    // Covariance of the inverse pose: dphi' = -R^T dphi, dt' = -R^T (t x dphi + dt).
    const Eigen::Matrix3d Rt = pair.T_m_c.linear().transpose();
    Matrix6d A = Matrix6d::Zero();
    A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = -Rt;
    A.bottomLeftCorner<3, 3>() = -Rt * skew(pair.T_m_c.translation());
    PlaneMeasurement m, swapped;
    ASSERT_TRUE(measurePlane(pair.scene, pair.model, pair.T_m_c, 0, m));
    ASSERT_TRUE(measurePlane(pair.model, pair.scene, pair.T_m_c.inverse(), 0, swapped));
    const double d2 = innovationDistance(m, P),
                 d2_swapped = innovationDistance(swapped, A * P * A.transpose());
    worst = std::max(worst, std::abs(d2 - d2_swapped) / d2);
  }
  EXPECT_LT(worst, 1e-3);
}

// Information of pairs whose model normals are given, all pairs exact.
Matrix6d informationOf(const std::vector<Eigen::Vector3d>& normals, Rng& rng) {
  Matrix6d sum = Matrix6d::Zero();
  for (const Eigen::Vector3d& n : normals) {
    Segment model = test::rectangle(gaussian<3>(rng) + 3 * n, n, 1, 0.7, uniform(rng, -3, 3));
    PlaneMeasurement m;
    EXPECT_TRUE(measurePlane(model, model, Eigen::Isometry3d::Identity(), 0, m));
    EXPECT_EQ(Eigen::FullPivLU<Matrix36d>(m.H).rank(), 3);
    sum += m.H.transpose() * m.W.inverse() * m.H;
  }
  return sum;
}

int rankOf(const Matrix6d& information) {
  Eigen::FullPivLU<Matrix6d> lu(information);
  lu.setThreshold(1e-9);
  return static_cast<int>(lu.rank());
}

TEST(PlaneMeasurement, OneTwoThreeNormalsFixThreeFiveSixDegreesOfFreedom) {
  Rng rng(12);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d a = test::randomDirection(rng), b = a.unitOrthogonal(), c = a.cross(b);
    EXPECT_EQ(rankOf(informationOf({a}, rng)), 3);
    EXPECT_EQ(rankOf(informationOf({a, a, a}, rng)), 3);  // parallel planes
    EXPECT_EQ(rankOf(informationOf({a, b}, rng)), 5);
    EXPECT_EQ(rankOf(informationOf({a, b, a + b, a - 0.3 * b}, rng)), 5);  // a corridor's cross section
    EXPECT_EQ(rankOf(informationOf({a, b, c}, rng)), 6);
    EXPECT_EQ(rankOf(informationOf({a, b, a + 0.2 * c}, rng)), 6);
  }
}

Segment board(const Eigen::Vector3d& t, double half_length, double half_width) {
  Segment s;
  s.R = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  s.t = t;
  s.lambda = {half_length * half_length / 3, half_width * half_width / 3};
  return s;
}

TEST(ExtentMeasurement, JacobianIsTheDerivative) {
  const Segment scene = board({0.1, 0.2, 1.5}, 0.3, 0.1), model = board({-0.2, 0.1, 1.3}, 0.2, 0.1);
  Eigen::Isometry3d T(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()));
  T.pretranslate(Eigen::Vector3d(0.3, -0.1, 0.2));
  const ExtentMeasurement m = measureExtent(scene, model, T);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 6; ++k) {
    const Vector6d d = kStep * Vector6d::Unit(k);
    const Eigen::Vector2d slope =
        (measureExtent(scene, model, boxplus(T, d)).h - measureExtent(scene, model, boxplus(T, -d)).h) /
        (2 * kStep);
    EXPECT_TRUE(slope.isApprox(m.H.col(k), 1e-6)) << k;
  }
}

// Two equal boards of half length a overlap up to 2 a apart: a uniform distance has the variance 4 a^2 / 3.
TEST(ExtentMeasurement, VarianceIsThatOfAllPositionsThatOverlap) {
  const Segment s = board({0, 0, 2}, 0.3, 0.1);
  const ExtentMeasurement m = measureExtent(s, s, Eigen::Isometry3d::Identity());
  EXPECT_NEAR(m.h.norm(), 0, 1e-12);
  EXPECT_NEAR(m.W(0, 0), 4 * 0.3 * 0.3 / 3, 1e-12);
  EXPECT_NEAR(m.W(1, 1), 4 * 0.1 * 0.1 / 3, 1e-12);
  EXPECT_NEAR(m.W(0, 1), 0, 1e-12);
}

TEST(ExtentMeasurement, ASegmentWithoutExtentSaysNothing) {
  const Segment s = board({0, 0, 2}, 0, 0);
  EXPECT_TRUE(informationOf(measureExtent(s, s, Eigen::Isometry3d::Identity())).isZero());
}

TEST(Cholesky3, AgreesWithTheInverse) {
  Rng rng(1);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Matrix3d S = test::randomCovariance<3>(rng, {0.01, 0.5, 3}), inverse = S.inverse();
    Cholesky3 cholesky;
    ASSERT_TRUE(cholesky.compute(S));
    const Eigen::Vector3d v = gaussian<3>(rng);
    Eigen::Matrix<double, 3, 6> M;
    for (int k = 0; k < 6; ++k) M.col(k) = gaussian<3>(rng);
    const double scale = inverse.norm();
    EXPECT_THAT(cholesky.solve(v), MatrixNear(inverse * v, 1e-11 * scale));
    EXPECT_THAT(cholesky.solve<6>(M), MatrixNear(inverse * M, 1e-11 * scale));
    EXPECT_NEAR(cholesky.whiten(v).squaredNorm(), v.dot(inverse * v), 1e-11 * scale);
    EXPECT_NEAR(cholesky.squaredMahalanobis(v), v.dot(inverse * v), 1e-11 * scale);
    EXPECT_NEAR(cholesky.logDeterminant(), std::log(S.determinant()), 1e-10);
  }
}

TEST(Cholesky3, RefusesMatricesThatAreNotPositiveDefinite) {
  Cholesky3 cholesky;
  EXPECT_FALSE(cholesky.compute(Eigen::Matrix3d::Zero()));
  EXPECT_FALSE(cholesky.compute(-Eigen::Matrix3d::Identity()));
  EXPECT_FALSE(cholesky.compute(Eigen::Matrix3d::Ones()));  // rank one
  EXPECT_FALSE(cholesky.compute(Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN())));
  for (int i = 0; i < 3; ++i) {
    Eigen::Matrix3d S = Eigen::Matrix3d::Identity();
    S(i, i) = -1e-9;
    EXPECT_FALSE(cholesky.compute(S)) << i;
    S(i, i) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(cholesky.compute(S)) << i;
  }
}

}  // namespace
}  // namespace facetloc
