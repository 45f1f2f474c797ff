// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/localization/localizer.h>
#include <facetloc/testing/synthetic_views.h>

#include <gmock/gmock.h>

#include <memory>
#include <random>

namespace facetloc {
namespace {

using test::box, test::lookingAlong, test::viewFrom;

constexpr double kRotationStd = 0.4 * kDegree, kTranslationStd = 0.01;  // calibration of the rig
constexpr double kEnd = 12;                                             // end of the corridor [m]

/** A corridor along y, 2 m wide and 2.6 m high, that ends at kEnd. */
test::Scene corridor() { return box({-1, -60, 0}, {1, kEnd, 2.6}); }

Eigen::Isometry3d forward(double x, double y, double turn) {
  return lookingAlong({x, y, 1}, {std::sin(turn), std::cos(turn), -0.17});
}

/** Mapped by one camera that looks forward and, at the end, back. */
std::shared_ptr<const Map> mapOfCorridor() {
  auto map = std::make_shared<Map>();
  unsigned seed = 100;
  for (double y = kEnd - 4; y < kEnd - 0.7; y += 0.5)
    for (const double turn : {0.0, double(EIGEN_PI)}) {
      const Eigen::Isometry3d T = forward(0.1, y, turn);
      map->models.emplace_back("", 0, T, viewFrom(corridor(), T, ++seed, 7.5));
    }
  return map;
}

/** Two cameras on a robot, one forward and one back, which is not exactly where it is said to be. */
struct Rig {
  PoseWithCovariance stated;  // T_first_second
  Eigen::Isometry3d truth;

  explicit Rig(std::mt19937& random) {
    const Eigen::Isometry3d front = forward(0, 0, 0), back = forward(0, -0.2, EIGEN_PI);
    Vector6d std;
    std << Eigen::Vector3d::Constant(kRotationStd), Eigen::Vector3d::Constant(kTranslationStd);
    std::normal_distribution<double> normal;
    const Vector6d error = Vector6d::NullaryExpr([&] { return normal(random); }).cwiseProduct(std);
    stated = {front.inverse() * back, std.cwiseAbs2().asDiagonal()};
    truth = boxplus(stated.T, error);
  }
};

// The front camera sees the wall at the end alone, the other one a corridor without an end.
TEST(JoinedViews, OfOppositeSidesOfACorridorsEndFixThePoseThatOneLeavesFree) {
  const std::shared_ptr<const Map> map = mapOfCorridor();
  std::mt19937 random(7);
  const Localizer alone(map), together(mapForRig(map, {Rig(random).stated.T}));
  const auto uniform = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  constexpr int kViews = 16;
  int free = 0, fixed = 0;
  double nees = 0;
  for (unsigned i = 0; i < kViews; ++i) {
    const Rig rig(random);
    const Eigen::Isometry3d T_w_c =
        forward(uniform(-0.2, 0.2), uniform(kEnd - 1.5, kEnd - 0.9), uniform(-0.1, 0.1));
    const View front = viewFrom(corridor(), T_w_c, 1000 + i, 7.5);
    const auto back = std::make_shared<const View>(viewFrom(corridor(), T_w_c * rig.truth, 2000 + i, 7.5));
    const Localization by_one = alone.localize(front),
                       by_both = together.localize(joined(front, {{back, rig.stated}}));
    EXPECT_FALSE(by_one.state == AnswerState::sure);
    free += by_one.hypotheses.empty() || !by_one.fixes_pose;
    if (by_both.hypotheses.empty() || !by_both.fixes_pose) continue;
    const Hypothesis& h = by_both.hypotheses.front();
    if (!isNear(*h.T_w_c, T_w_c, 0.3, 5)) continue;
    ++fixed;
    const Eigen::Isometry3d T_m_w = map->models[h.model].T_w_m->inverse();
    nees += squaredMahalanobis({T_m_w * *h.T_w_c, h.T_m_c.P}, T_m_w * T_w_c);
  }
  EXPECT_EQ(free, kViews);
  EXPECT_GE(fixed, 3 * kViews / 4);
  EXPECT_LE(nees / fixed, 6 * 1.5);  // errors of the calibration included
}

}  // namespace
}  // namespace facetloc
