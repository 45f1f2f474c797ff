// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/testing/numeric_jacobian.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {
namespace {

using test::gaussian, test::IsRotation, test::MatrixNear, test::PoseNear, test::randomDirection, test::Rng;

TEST(Pose, BoxminusUndoesBoxplus) {
  Rng rng(8);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Isometry3d T = test::randomPose(rng, 3, 5);
    Vector6d d = gaussian<6>(rng);
    d.head<3>() *= 0.5;
    const Eigen::Isometry3d moved = boxplus(T, d);
    EXPECT_THAT(boxminus(moved, T), MatrixNear(d, 1e-12));
    EXPECT_THAT(boxplus(T, Vector6d::Zero()), PoseNear(T, 0, 1e-12));
    // Left and decoupled: the rotation error is in the outer frame, the position moves by d t alone.
    EXPECT_THAT(moved.linear(), MatrixNear(expSO3(d.head<3>()) * T.linear(), 1e-14));
    EXPECT_THAT(moved.translation(), MatrixNear(T.translation() + d.tail<3>(), 1e-15));
  }
}

TEST(Pose, APoseMovedAgainAndAgainStaysAPose) {
  Rng rng(11);
  Eigen::Isometry3d T = test::randomPose(rng, 3, 5), other = T;
  for (int i = 0; i < 100000; ++i) {
    const Eigen::Isometry3d motion = other.inverse() * boxplus(T, 0.01 * gaussian<6>(rng));
    other = T;
    T = boxplus(T * motion, Vector6d::Zero());  // its error would double with each
  }
  EXPECT_THAT(T.linear().eval(), IsRotation());
}

TEST(Pose, NearIsBothInPlaceAndInDirection) {
  const auto at = [](double x, double degrees) {
    return Eigen::Translation3d(x, 0, 0) * Eigen::Isometry3d(expSO3({0, 0, degrees * kDegree}));
  };
  EXPECT_TRUE(isNear(at(0, 0), at(0.19, 2.9), 0.2, 3));
  EXPECT_FALSE(isNear(at(0, 0), at(0.21, 0), 0.2, 3));
  EXPECT_FALSE(isNear(at(0, 0), at(0, 3.1), 0.2, 3));
}

TEST(Pose, MahalanobisDistanceCountsInStandardDeviations) {
  PoseWithCovariance pose;
  pose.P.diagonal() << 0.01, 0.04, 0.09, 0.25, 1, 4;
  Vector6d d;
  d << 0.1, -0.2, 0.3, 0.5, -1, 2;  // each one standard deviation
  EXPECT_NEAR(squaredMahalanobis(pose, boxplus(pose.T, 2 * d)), 4 * 6, 1e-9);
  EXPECT_EQ(squaredMahalanobis(pose, pose.T), 0);
  PoseWithCovariance other{boxplus(pose.T, 2 * d), 3 * pose.P};
  EXPECT_NEAR(squaredMahalanobis(pose, other), 6, 1e-9) << "the errors of both";
}

// Its mean is the number of degrees of freedom, whatever the covariance.
TEST(Pose, MahalanobisDistanceIsChiSquare) {
  Rng rng(12);
  const Matrix6d A = Matrix6d::Random();
  const Eigen::Isometry3d T = test::randomPose(rng, 0.5, 5);
  const PoseWithCovariance pose{T, 1e-4 * (A * A.transpose() + Matrix6d::Identity())};
  const Matrix6d L = pose.P.llt().matrixL();
  constexpr int kTrials = 20000;
  double sum = 0;
  for (int i = 0; i < kTrials; ++i) sum += squaredMahalanobis(pose, boxplus(T, L * gaussian<6>(rng)));
  EXPECT_NEAR(sum / kTrials, 6, 0.1);  // standard deviation of the mean: 0.024
}

TEST(Pose, APoseInAnotherFrameHasThePerturbationOfThatFrame) {
  Rng rng(9);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Isometry3d T_a_b = test::randomPose(rng, 3, 5), T_b_c = test::randomPose(rng, 3, 5);
    Matrix6d root;
    for (int k = 0; k < 6; ++k) root.col(k) = gaussian<6>(rng);
    const Matrix6d P = root * root.transpose();
    const auto inA = [&](const Vector6d& d) { return boxminus(T_a_b * boxplus(T_b_c, d), T_a_b * T_b_c); };
    const Matrix6d J = test::numericJacobian<6, 6>(inA, Vector6d::Zero().eval());
    const PoseWithCovariance T_a_c = T_a_b * PoseWithCovariance{T_b_c, P};
    EXPECT_THAT(T_a_c.T, PoseNear(T_a_b * T_b_c, 1e-12, 1e-12));
    EXPECT_THAT(T_a_c.P, MatrixNear(J * P * J.transpose(), 1e-7 * P.norm()));
  }
}

TEST(Pose, TheInverseHasThePerturbationOfTheOtherFrame) {
  Rng rng(10);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Isometry3d T = test::randomPose(rng, 3, 5);
    Matrix6d root;
    for (int k = 0; k < 6; ++k) root.col(k) = gaussian<6>(rng);
    const Matrix6d P = root * root.transpose();
    const auto inverted = [&](const Vector6d& d) { return boxminus(boxplus(T, d).inverse(), T.inverse()); };
    const Matrix6d J = test::numericJacobian<6, 6>(inverted, Vector6d::Zero().eval());
    EXPECT_THAT(inverse({T, P}).T, PoseNear(T.inverse(), 1e-12, 1e-12));
    EXPECT_THAT(inverse({T, P}).P, MatrixNear(J * P * J.transpose(), 1e-7 * P.norm()));
  }
}

/** A covariance with correlations, small enough for first order. */
Matrix6d randomCovariance(Rng& rng, double scale) {
  Matrix6d A;
  for (int k = 0; k < 36; ++k) A(k / 6, k % 6) = test::gaussian<1>(rng)[0];
  return scale * scale * (A * A.transpose() / 6 + 0.1 * Matrix6d::Identity());
}

/** Compares samples d = boxminus(sample, T) with a covariance. */
template <class Sample>
void expectCovariance(const Matrix6d& P, const Sample& sample) {
  constexpr int kSamples = 40000;
  Matrix6d found = Matrix6d::Zero();
  for (int i = 0; i < kSamples; ++i) {
    const Vector6d d = sample();
    found += d * d.transpose() / kSamples;
  }
  const Vector6d s = P.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6d error = s.asDiagonal() * (found - P) * s.asDiagonal();
  EXPECT_LT(error.cwiseAbs().maxCoeff(), 0.04);
}

TEST(Pose, TheErrorOfAProductIsThatOfItsFactors) {
  Rng rng(21);
  const PoseWithCovariance a{test::randomPose(rng, 3, 5), randomCovariance(rng, 3e-3)},
      b{test::randomPose(rng, 3, 5), randomCovariance(rng, 3e-3)}, product = a * b;
  const Matrix6d La = a.P.llt().matrixL(), Lb = b.P.llt().matrixL();
  expectCovariance(product.P, [&] {
    const Eigen::Isometry3d T =
        boxplus(a.T, La * test::gaussian<6>(rng)) * boxplus(b.T, Lb * test::gaussian<6>(rng));
    return boxminus(T, product.T);
  });
  // The covariance of an exact first factor only turns the second one's.
  const PoseWithCovariance exact = PoseWithCovariance{a.T, Matrix6d::Zero()} * b;
  EXPECT_LT((exact.P - (a.T * b).P).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Pose, TheAdjointMovesTwistsToAnotherFrame) {
  Rng rng(22);
  const Eigen::Isometry3d T_a_b = test::randomPose(rng, 3, 5);
  const double dt = 1e-7;
  const Eigen::Vector3d omega = test::gaussian<3>(rng), v = test::gaussian<3>(rng);
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();  // motion of frame b in its own axes
  motion.linear() = expSO3(dt * omega);
  motion.translation() = dt * v;
  const Eigen::Isometry3d same =
      T_a_b * motion * T_a_b.inverse();  // the same in the axes of a, at its origin
  Vector6d twist, expected;
  twist << omega, v;
  expected << logSO3(same.linear()) / dt, same.translation() / dt;
  EXPECT_LT((adjoint(T_a_b) * twist - expected).norm(), 1e-5);
}

TEST(Pose, TheSymmetricInverseIsSymmetricToTheLastBit) {
  Rng rng(23);
  const Matrix6d A = randomCovariance(rng, 0.1), inverse = symmetricInverse(A);
  EXPECT_EQ(inverse, Matrix6d(inverse.transpose()));
  EXPECT_LT((A * inverse - Matrix6d::Identity()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Pose, PrincipalDirectionsAreThoseOfTheBlocks) {
  Rng rng(24);
  const Eigen::Matrix3d R = test::randomPose(rng, 3, 5).linear();
  Matrix6d P = Matrix6d::Zero();
  P.diagonal() << 1e-4, 4e-4, 9e-4, 0.01, 0.04, 0.25;
  const PrincipalStd known = principalStd(rotateCovariance(R, P));
  EXPECT_LT((known.rotation - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 1e-9);
  EXPECT_LT((known.translation - Eigen::Vector3d(0.1, 0.2, 0.5)).norm(), 1e-9);
  EXPECT_NEAR(std::abs(known.rotation_axes.col(2).dot(R.col(2))), 1, 1e-9);
  EXPECT_NEAR(std::abs(known.translation_axes.col(0).dot(R.col(0))), 1, 1e-9);
  EXPECT_NEAR(largestRotationStd(rotateCovariance(R, P)), 0.03, 1e-9);
  EXPECT_NEAR(largestTranslationStd(rotateCovariance(R, P)), 0.5, 1e-9);
  EXPECT_TRUE(known.within(0.031, 0.51));
  EXPECT_FALSE(known.within(0.029, 0.51));
  EXPECT_TRUE(known.oneTranslationFree(0.031, 0.3));
  EXPECT_FALSE(known.oneTranslationFree(0.031, 0.15));  // two are
}

TEST(Pose, FreeMotionsAreWordedWithoutSigns) {
  Matrix6d P = Matrix6d::Zero();
  P.diagonal() << 1, 1e-6, 1e-6, 1e-6, 4, 1e-6;
  EXPECT_EQ(freeMotions(principalStd(P), 0.1, 0.1),
            "rotation about (1.00, 0.00, 0.00), translation along (0.00, 1.00, 0.00)");
  const Eigen::Matrix3d R = expSO3({0, 0, 90 * kDegree});  // words in other axes
  EXPECT_EQ(freeMotions(principalStd(P), 10, 0.1, R), "translation along (1.00, 0.00, 0.00)");
  EXPECT_EQ(freeMotions(principalStd(P), 10, 10), "");
}

}  // namespace
}  // namespace facetloc
