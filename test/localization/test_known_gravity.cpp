// SPDX-License-Identifier: BSD-3-Clause
#include "opened_map.h"
#include "ranking/global_localization.h"
#include "shortlist/known_gravity.h"

#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

namespace facetloc {
namespace {

using namespace internal;
using test::onCircle, test::roomMap;

const Eigen::Vector3d kDown = -Eigen::Vector3d::UnitZ();

Gravity gravityAt(const Eigen::Isometry3d& T_w_c, double std = kDegree) {
  return {T_w_c.linear().transpose() * kDown, std};
}

Eigen::Isometry3d rolled(const Eigen::Isometry3d& T, double degrees) {
  return T * Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d::UnitZ());
}

TEST(KnownGravity, FixesRollAndPitchOfAPrior) {
  const Eigen::Isometry3d model = onCircle(0, 0), view = rolled(onCircle(10, 0, 1.2, -0.3), 70);
  PoseWithCovariance prior{Eigen::Isometry3d::Identity(), posePrior({})};
  const PoseWithCovariance out = correctedByGravity(prior, gravityAt(model), gravityAt(view), false);
  const Eigen::Isometry3d truth = model.inverse() * view;
  const Eigen::Vector3d off = logSO3(truth.linear() * out.T.linear().transpose());
  const Eigen::Vector3d down_m = gravityAt(model).down;
  EXPECT_NEAR(std::abs(off.dot(down_m)), 10 * kDegree, 1e-6) << "all that is left is the heading";
  EXPECT_NEAR(off.norm(), 10 * kDegree, 1e-6);
  EXPECT_NEAR(std::sqrt(down_m.dot(out.P.topLeftCorner<3, 3>() * down_m)), 20 * kDegree, 1e-6);
  const Eigen::Vector3d level = down_m.unitOrthogonal();
  EXPECT_NEAR(std::sqrt(level.dot(out.P.topLeftCorner<3, 3>() * level)), std::sqrt(2.0) * kDegree, 1e-3);
  EXPECT_EQ(out.P.llt().info(), Eigen::Success);
}

TEST(KnownGravity, CorrectsAPriorThatKeepsItsMean) {
  PoseWithCovariance prior{Eigen::Isometry3d(Eigen::AngleAxisd(50 * kDegree, Eigen::Vector3d::UnitY())),
                           posePrior({})};
  const Gravity level{Eigen::Vector3d::UnitY(), kDegree};
  const Gravity leaning{expSO3({0, 0, 3 * kDegree}) * Eigen::Vector3d::UnitY(), kDegree};
  const PoseWithCovariance out = correctedByGravity(prior, level, leaning, true);
  const Eigen::Vector3d off = logSO3(out.T.linear() * prior.T.linear().transpose());
  EXPECT_NEAR(off.y(), 0, 1e-3) << "the heading stays";
  EXPECT_LT(rotationAngle(rotationBetween(out.T.linear() * leaning.down, level.down)), 0.1 * kDegree);
}

TEST(KnownGravity, OfAMapComesFromItsImagesItsMountingOrItsWorld) {
  const auto map = roomMap();
  EXPECT_TRUE(isWorldLevel(*map));
  const MapGravity by_world(*map);
  const auto found = by_world.of(0, *map->view(0));
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->down.isApprox(gravityAt(*map->models[0].T_w_m).down, 1e-9));

  View measured = *map->view(1);
  measured.gravity = Gravity{Eigen::Vector3d::UnitX(), kDegree};
  EXPECT_TRUE(by_world.of(1, measured)->down.isApprox(Eigen::Vector3d::UnitX()));

  for (LocalModel& model : map->models)
    model.T_w_m = Eigen::AngleAxisd(12 * kDegree, Eigen::Vector3d(1, 1, 0).normalized()) * *model.T_w_m;
  EXPECT_FALSE(isWorldLevel(*map)) << "a world that leans";
  EXPECT_FALSE(MapGravity(*map).of(0, *map->view(0)));
  for (LocalModel& model : map->models)
    model.T_w_m = Eigen::AngleAxisd(90 * kDegree, Eigen::Vector3d::UnitX()) * *roomMap()->models[0].T_w_m;
  EXPECT_FALSE(isWorldLevel(*map)) << "a world whose y axis is vertical";
}

TEST(KnownGravity, FindsACameraThatIsHeldInAnyWay) {
  const auto map = roomMap();
  const GlobalLocalization localization(map);
  int right = 0;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Isometry3d truth = rolled(onCircle(15 + 90 * i, 0.5), 55);
    View view = test::viewFrom(test::largeRoom(), truth, 7 + i);
    view.gravity = gravityAt(truth);
    const Localization answer = localization.localize(view);
    ASSERT_FALSE(answer.hypotheses.empty()) << answer.reason;
    right += isNear(*answer.hypotheses.front().T_w_c, truth, 0.1, 2);
    EXPECT_EQ(answer.hypotheses.front().T_m_c.P.llt().info(), Eigen::Success);
  }
  EXPECT_GE(right, 3);
}

TEST(KnownGravity, ThatIsImpossibleIsIgnored) {
  const auto map = roomMap();
  const GlobalLocalization localization(map);
  View view = test::viewFrom(test::largeRoom(), onCircle(100, 0.5), 3);
  const Localization without = localization.localize(view);
  view.gravity = Gravity{{0, 0, 0}, kDegree};
  const Localization with = localization.localize(view);
  ASSERT_EQ(with.hypotheses.size(), without.hypotheses.size());
  for (std::size_t i = 0; i < with.hypotheses.size(); ++i)
    EXPECT_EQ(with.hypotheses[i].probability, without.hypotheses[i].probability);
}

}  // namespace
}  // namespace facetloc
