// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/view_registration.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

namespace facetloc {
namespace {

using namespace internal;
using test::lookingAlong, test::Scene;

Scene corridorWithABox() { return test::endlessCorridor() + test::box({0.4, 3, 0}, {0.9, 3.6, 1.2}); }

DepthPicture seenAt(const Scene& scene, double y, unsigned seed) {
  const DepthImage image =
      test::render(scene, test::smallCamera(), lookingAlong({0, y, 1.2}, {0, 1, -0.15}), 60).image;
  return DepthPicture::fromDepth(test::noisy(image, SensorNoise{}.inverse_depth_std, seed));
}

// Positions of the scene camera along the corridor, which is forward, given in axes of the model camera.
std::vector<double> align(const Scene& scene, double true_shift, double start = 0) {
  const Eigen::Isometry3d T_w_m = lookingAlong({0, 0, 1.2}, {0, 1, -0.15});
  const Eigen::Vector3d along = T_w_m.linear().transpose() * Eigen::Vector3d::UnitY();
  Eigen::Isometry3d T_m_c = Eigen::Isometry3d::Identity();
  T_m_c.translation() = start * along;  // the direction that the planes leave open
  return alignDepth(seenAt(scene, true_shift, 1), seenAt(scene, 0, 2), T_m_c, along, 0, DepthComparison({}));
}

TEST(DepthAlignment, FindsTheShiftAlongACorridorWithABox) {
  for (const double shift : {-1.13, -0.5, 0.0, 0.27, 0.8, 1.2}) {
    const std::vector<double> positions = align(corridorWithABox(), shift);
    ASSERT_FALSE(positions.empty()) << shift;
    EXPECT_LE(positions.size(), 2u);
    EXPECT_NEAR(positions[0], shift, 0.05) << shift;
  }
}

TEST(DepthAlignment, DoesNotDependOnWhereThePoseStoodAlongTheDirection) {
  EXPECT_EQ(align(corridorWithABox(), 0.5), align(corridorWithABox(), 0.5, 3.0));
}

TEST(DepthAlignment, RefusesABareCorridor) {
  // Every position along the corridor shows the same: there is nothing to find.
  for (const double shift : {-0.8, 0.0, 0.6})
    EXPECT_TRUE(align(test::endlessCorridor(), shift).empty()) << shift;
}

// Near a wall even pixels that agree are less likely than average ones far away.
TEST(DepthAlignment, NeverLeadsWhereThePicturesShareNothing) {
  const DepthComparison comparison({});
  const Eigen::Isometry3d T_w_m = lookingAlong({0, 0, 1}, {0, 1, 0});
  const Eigen::Vector3d along = T_w_m.linear().transpose() * Eigen::Vector3d::UnitX();
  int found_at_all = 0;
  for (const double wall : {0.6, 0.8, 1.2})
    for (double shift = -1.2; shift <= 1.21; shift += 0.2) {
      const Scene recess = test::box({-20, wall, -10}, {-0.2, wall + 1, 10}) +
                           test::box({0.3, wall, -10}, {20, wall + 1, 10}) +
                           test::box({-0.2, wall + 0.15, -10}, {0.3, wall + 1, 10});
      const auto seenFrom = [&](double x, unsigned seed) {
        const DepthImage image =
            test::render(recess, test::smallCamera(), lookingAlong({x, 0, 1}, {0, 1, 0}), 60).image;
        return DepthPicture::fromDepth(test::noisy(image, SensorNoise{}.inverse_depth_std, seed));
      };
      const DepthPicture scene = seenFrom(shift, 1), model = seenFrom(0, 2);
      for (const double step : {0.1, 0.2}) {
        DepthAlignmentParams params;
        params.step = step;
        for (const double position :
             alignDepth(scene, model, Eigen::Isometry3d::Identity(), along, 0, comparison, params)) {
          const Eigen::Isometry3d there(Eigen::Translation3d(position * along));
          EXPECT_GT(comparison.compareBoth(scene, model, there, kFineColumns).judged(), 0) << wall << shift;
          ++found_at_all;
        }
      }
    }
  EXPECT_GT(found_at_all, 20);
}

TEST(DepthAlignment, WithoutPicturesFindsNothing) {
  const DepthComparison comparison({});
  const DepthPicture picture = seenAt(corridorWithABox(), 0, 1);
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  EXPECT_TRUE(alignDepth({}, picture, here, Eigen::Vector3d::UnitZ(), 0, comparison).empty());
  EXPECT_TRUE(alignDepth(picture, {}, here, Eigen::Vector3d::UnitZ(), 0, comparison).empty());
}

}  // namespace
}  // namespace facetloc
