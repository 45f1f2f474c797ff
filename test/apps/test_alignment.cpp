// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/alignment.h"

#include <facetloc/features/pose.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace facetloc::test {
namespace {

Eigen::Isometry3d pose(const Eigen::Vector3d& t, const Eigen::Vector3d& rotation) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = expSO3(rotation);
  T.translation() = t;
  return T;
}

const Eigen::Isometry3d kMotion = pose({3, -2, 1}, {0.3, -0.5, 2});

/** A spiral, as it is and in another frame. */
std::vector<PosePair> spiral(int n) {
  std::vector<PosePair> pairs;
  for (int i = 0; i < n; ++i) {
    const Eigen::Isometry3d truth =
        pose({std::cos(0.3 * i), std::sin(0.3 * i), 0.05 * i}, {0.1 * i, 0.02 * i, -0.05 * i});
    pairs.push_back({i * 0.1, kMotion.inverse() * truth, truth});
  }
  return pairs;
}

TEST(Alignment, FindsTheMotion) {
  const Alignment a = aligned(spiral(20));
  EXPECT_TRUE(a.T_true_estimated.isApprox(kMotion, 1e-9));
  EXPECT_EQ(a.used, 20u);
  EXPECT_NEAR(a.residual, 0, 1e-9);
}

TEST(Alignment, HasTheResidualOfSymmetricErrors) {
  std::vector<PosePair> pairs;  // a square whose corners are off, alternately up and down: no motion helps
  for (int i = 0; i < 4; ++i) {
    const Eigen::Isometry3d truth = pose({i % 2 ? 1. : -1., i / 2 ? 1. : -1., 0}, {0, 0, 0});
    const double off = (i == 0 || i == 3) ? 0.03 : -0.03;
    pairs.push_back({double(i), pose(truth.translation() + Eigen::Vector3d(0, 0, off), {0, 0, 0}), truth});
  }
  const Alignment a = aligned(pairs);
  EXPECT_TRUE(a.T_true_estimated.isApprox(Eigen::Isometry3d::Identity(), 1e-9));
  EXPECT_NEAR(a.residual, 0.03, 1e-12);
}

TEST(Alignment, OrientationsFixTheRollOfPositionsOnALine) {
  std::vector<PosePair> pairs;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Isometry3d truth = pose({0.5 * i, 0, 0}, {0.2, 0.1 * i, 0});
    pairs.push_back({double(i), kMotion.inverse() * truth, truth});
  }
  EXPECT_TRUE(aligned(pairs).T_true_estimated.isApprox(kMotion, 1e-9));
  for (PosePair& pair : pairs) pair.truth = pairs[0].truth;  // nor does a standing camera leave anything open
  for (PosePair& pair : pairs) pair.estimated = pairs[0].estimated;
  EXPECT_TRUE(aligned(pairs).T_true_estimated.isApprox(kMotion, 1e-9));
}

TEST(RobustAlignment, RejectsOutliers) {
  std::vector<PosePair> pairs = spiral(40);
  for (std::size_t i = 0; i < pairs.size(); i += 5)  // every fifth
    pairs[i].estimated = pose({5. + double(i), -3, 2}, {0, 0, 0}) * pairs[i].estimated;
  const Alignment robust = robustlyAligned(pairs);
  EXPECT_TRUE(robust.T_true_estimated.isApprox(kMotion, 1e-9));
  EXPECT_EQ(robust.used, 32u);
  EXPECT_FALSE(aligned(pairs).T_true_estimated.isApprox(kMotion, 1e-1));
}

TEST(RobustAlignment, KeepsAllThatIsExact) { EXPECT_EQ(robustlyAligned(spiral(7)).used, 7u); }

TEST(RobustAlignment, IsTheSameEveryTime) {
  std::vector<PosePair> pairs = spiral(30);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    pairs[i].estimated.translation().x() += 0.01 * std::sin(17. * double(i * i));
  EXPECT_EQ(robustlyAligned(pairs).T_true_estimated.matrix(),
            robustlyAligned(pairs).T_true_estimated.matrix());
}

/** A camera in a space of half a metre, with Gaussian errors of positions and orientations. */
std::vector<PosePair> room(int n, double position_std, double rotation_std) {
  Rng rng(3);
  std::vector<PosePair> pairs;
  for (int i = 0; i < n; ++i) {
    const Eigen::Isometry3d truth = randomPose(rng, 3, 0.5);
    Eigen::Isometry3d estimated = kMotion.inverse() * truth;
    estimated.translation() += position_std * gaussian<3>(rng);
    estimated.linear() = expSO3(rotation_std * gaussian<3>(rng)) * estimated.linear();
    pairs.push_back({double(i), estimated, truth});
  }
  return pairs;
}

double rotationErrorDeg(const Alignment& a) {
  return rotationAngle(a.T_true_estimated.linear() * kMotion.linear().transpose()) / kDegree;
}

TEST(RobustAlignment, OrientationsFixTheRotationOfClosePositions) {
  const int n = 200;
  const double position_std = 0.1, rotation_std = 1 * kDegree;
  const std::vector<PosePair> pairs = room(n, position_std, rotation_std);
  const Alignment whole = robustlyAligned(pairs), positions = robustlyAligned(pairs, 0);
  // The mean of n orientations has the error of one over sqrt(n), in each of three axes.
  EXPECT_LT(rotationErrorDeg(whole), 2.5 * std::sqrt(3. / n));
  EXPECT_GT(rotationErrorDeg(positions), 2 * rotationErrorDeg(whole));
  EXPECT_LT((whole.T_true_estimated.translation() - kMotion.translation()).norm(), 0.05);
  EXPECT_NEAR(whole.residual, position_std * std::sqrt(3.), 0.02);
  EXPECT_NEAR(whole.rotation_residual_deg, std::sqrt(3.), 0.2);
}

TEST(RobustAlignment, AWrongOrientationIsRejected) {
  std::vector<PosePair> pairs = spiral(40);
  for (std::size_t i = 0; i < pairs.size(); i += 5) pairs[i].estimated.rotate(expSO3({0, 1, 0}));
  const Alignment a = robustlyAligned(pairs);
  EXPECT_TRUE(a.T_true_estimated.isApprox(kMotion, 1e-9));
  EXPECT_EQ(a.used, 32u);
}

TEST(RobustAlignment, IsTheMinimumOfItsSum) {
  for (const double lever : {0.0, 0.5, kPoseLever}) {
    const std::vector<PosePair> pairs = room(30, 0.02, 0.5 * kDegree);
    const auto sum = [&](const Eigen::Isometry3d& T) {
      double total = 0;
      for (const PosePair& pair : pairs) {
        const Eigen::Isometry3d moved = T * pair.estimated;
        total += (moved.translation() - pair.truth.translation()).squaredNorm() +
                 lever * lever / 2 * (moved.linear() - pair.truth.linear()).squaredNorm();
      }
      return total;
    };
    const Alignment a = robustlyAligned(pairs, lever);
    ASSERT_EQ(a.used, pairs.size()) << "none is that far off";
    for (int axis = 0; axis < 3; ++axis)
      for (const double step : {-1e-4, 1e-4}) {
        const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(axis);
        Eigen::Isometry3d turned = a.T_true_estimated, shifted = a.T_true_estimated;
        turned.linear() = expSO3(d) * turned.linear();
        shifted.translation() += d;
        EXPECT_GT(sum(turned), sum(a.T_true_estimated)) << lever;
        EXPECT_GT(sum(shifted), sum(a.T_true_estimated)) << lever;
      }
  }
}

TEST(Alignment, NeedsThreePairs) {
  EXPECT_THROW(aligned(spiral(2)), std::invalid_argument);
  EXPECT_THROW(robustlyAligned({}), std::invalid_argument);
  EXPECT_NO_THROW(aligned(spiral(3)));
}

}  // namespace
}  // namespace facetloc::test
