// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/alignment.h"

#include <facetloc/features/so3.h>

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace facetloc {
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

TEST(Alignment, OnALineTheOrientationsTellTheRoll) {
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

TEST(RobustAlignment, LeavesOutWhatIsWrong) {
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

TEST(Alignment, NeedsThreePairs) {
  EXPECT_THROW(aligned(spiral(2)), std::invalid_argument);
  EXPECT_THROW(robustlyAligned({}), std::invalid_argument);
  EXPECT_NO_THROW(aligned(spiral(3)));
}

}  // namespace
}  // namespace facetloc
