// SPDX-License-Identifier: BSD-3-Clause
#include "depth/depth_fit.h"

#include <facetloc/testing/synthetic_views.h>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {

using namespace internal;
using test::endlessCorridor, test::largeRoom, test::lookingAlong, test::viewFrom;
namespace {

/** Two views of a scene, and how the second fits the first. */
struct Pair {
  Pair(const test::Scene& scene, const Eigen::Isometry3d& first, const Eigen::Isometry3d& second,
       double farthest = 20)
      : T_a_b(first.inverse() * second),
        a(viewFrom(scene, first, 1, farthest)),
        b(viewFrom(scene, second, 2, farthest)),
        fit(b.depth, {{&a.depth, Eigen::Isometry3d::Identity()}}, comparison) {}

  Eigen::Isometry3d T_a_b;
  View a, b;
  DepthComparison comparison{DepthCalibration{}};
  DepthFit fit;
};

Vector6d along(const Eigen::Isometry3d& camera, const Eigen::Vector3d& direction) {
  Vector6d motion = Vector6d::Zero();
  motion.tail<3>() = camera.linear().transpose() * direction;
  return motion;
}

double stdAlong(const Matrix6d& information, const Vector6d& motion) {
  const Matrix6d P = symmetricInverse(information + 1e-4 * Matrix6d::Identity());
  return std::sqrt(motion.dot(P * motion));
}

const Eigen::Isometry3d kInCorridor = lookingAlong({0, 0, 1.2}, {0, 1, -0.2});

TEST(DepthFit, IsBestAtTheTruth) {
  const Pair pair(largeRoom(), lookingAlong({2.5, 2, 1.2}, {1, 0.6, -0.25}),
                  lookingAlong({2.7, 2.1, 1.2}, {0.95, 0.75, -0.25}));
  const auto here = pair.fit(pair.T_a_b, kFineColumns);
  ASSERT_TRUE(here);
  EXPECT_LE(*here, 0);
  for (int k = 0; k < 6; ++k)
    for (const double step : {-0.1, 0.1}) {
      const auto there = pair.fit(boxplus(pair.T_a_b, step * Vector6d::Unit(k)), kFineColumns);
      ASSERT_TRUE(there) << k;
      EXPECT_LT(*there, *here - 2) << k;
    }
}

TEST(DepthFit, SaysNothingWhereHardlyAnythingIsCompared) {
  const Eigen::Isometry3d there = lookingAlong({3, 2.5, 1.2}, {1, 0.3, -0.2});
  const Pair pair(largeRoom(), there, lookingAlong({3, 2.5, 1.2}, {-1, 0.3, -0.2}));
  EXPECT_FALSE(pair.fit(pair.T_a_b, kFineColumns));
  const Matrix6d stated = 1e4 * Matrix6d::Identity();
  EXPECT_EQ(shownInformation(stated, pair.T_a_b, pair.fit, kFineColumns).information, stated);
}

TEST(ShownInformation, FeignedOnesAlongACorridorGo) {
  const Eigen::Isometry3d later = lookingAlong({0, 0.2, 1.2}, {0, 1, -0.2});
  const Pair pair(endlessCorridor(), kInCorridor, later, 5);
  const Vector6d ahead = along(kInCorridor, Eigen::Vector3d::UnitY()),
                 sideways = along(kInCorridor, Eigen::Vector3d::UnitX());
  const Matrix6d stated = 1e4 * Matrix6d::Identity() - (1e4 - 2500) * ahead * ahead.transpose();  // 1, 2 cm
  const ShownInformation shown = shownInformation(stated, pair.T_a_b, pair.fit, kFineColumns);
  EXPECT_GT(stdAlong(shown.information, ahead), 1) << "ahead";
  EXPECT_LT(stdAlong(shown.information, sideways), 0.02) << "sideways";
  EXPECT_LT(ahead.dot(shown.share * ahead), 0.01);
  EXPECT_GT(sideways.dot(shown.share * sideways), 0.5);
}

TEST(ShownInformation, InformationShownByTheCostStays) {
  const Pair pair(largeRoom(), lookingAlong({2.5, 2, 1.2}, {1, 0.6, -0.25}),
                  lookingAlong({2.7, 2.1, 1.2}, {0.95, 0.75, -0.25}));
  const Matrix6d stated = 2500 * Matrix6d::Identity();  // 2 cm, 1.1 deg
  const ShownInformation shown = shownInformation(stated, pair.T_a_b, pair.fit, kFineColumns);
  EXPECT_TRUE(shown.information.isApprox(stated, 1e-6));
  EXPECT_TRUE(shown.share.isApprox(Matrix6d::Identity(), 1e-6));
}

TEST(ShownInformation, NothingStatedIsFoundInTheCost) {
  const Pair pair(largeRoom(), lookingAlong({2.5, 2, 1.2}, {1, 0.6, -0.25}),
                  lookingAlong({2.7, 2.1, 1.2}, {0.95, 0.75, -0.25}));
  const ShownInformation shown = shownInformation(Matrix6d::Zero(), pair.T_a_b, pair.fit, kFineColumns);
  EXPECT_EQ(Eigen::LLT<Matrix6d>(shown.information).info(), Eigen::Success);
  EXPECT_TRUE(shown.share.isApprox(Matrix6d::Identity(), 1e-9));
}

}  // namespace
}  // namespace facetloc
