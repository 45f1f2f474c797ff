// SPDX-License-Identifier: BSD-3-Clause
#include "shortlist/plane_triplet_matcher.h"

#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace facetloc {

using namespace internal;
using namespace test;
namespace {

PoseWithCovariance anywhere() { return {Eigen::Isometry3d::Identity(), posePrior({})}; }

Overlay overlayOf(const View& scene, const View& model) {
  return PlaneTripletMatcher(scene, anywhere()).on(PlaneColumns(model));
}

// A camera in the hand of somebody in the room, who holds it any way up.
class Hand {
public:
  explicit Hand(unsigned seed) : random_(seed) {}
  Eigen::Isometry3d somewhere() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const Eigen::Vector3d heading(0, 0, 3 * uniform_(random_)), attitude = 0.8 * any();
    T.linear() = expSO3(heading) * CameraMounting{1.0, 10.0}.T_b_c().linear() * expSO3(attitude);
    T.translation() = Eigen::Vector3d(3, 2.5, 1.4) + 0.5 * any();
    return T;
  }
  Eigen::Isometry3d motion() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = expSO3(0.2 * any());
    T.translation() = 0.3 * any();
    return T;
  }

private:
  Eigen::Vector3d any() { return {uniform_(random_), uniform_(random_), uniform_(random_)}; }
  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

// The share of the planes of the scene that a pose lays on a plane of the model, one by one.
double shareLaid(const View& scene, const View& model, const Eigen::Isometry3d& T_m_c) {
  double laid = 0, all = 0;
  for (const Segment& unmoved : scene.segments) {
    const Segment s = transformed(unmoved, T_m_c);
    const double weight = std::sqrt(double(s.num_points));
    all += weight;
    for (const Segment& m : model.segments) {
      const double reach = 1.2 * (std::sqrt(3 * s.lambda.x()) + std::sqrt(3 * m.lambda.x())) + 0.1;
      if (s.normal().dot(m.normal()) < std::cos(8 * kDegree) || (s.t - m.t).norm() > reach ||
          std::abs(m.normal().dot(s.t) - m.offset()) > 0.05 + 0.02 * unmoved.t.z())
        continue;
      laid += weight;
      break;
    }
  }
  return laid / all;
}

double distanceFromPrior(const Eigen::Isometry3d& T) {
  const double angle = rotationAngle(T.linear()) / (20 * kDegree);
  return angle * angle + T.translation().squaredNorm();
}

TEST(PlaneTripletMatcher, FindsTheMotionBetweenTwoViewsInAnyAttitude) {
  Hand hand(7);
  int views = 0, found = 0;
  for (unsigned i = 0; i < 60; ++i) {
    const Eigen::Isometry3d T_w_m = hand.somewhere(), T_m_c = hand.motion();
    const View model = viewFrom(test::largeRoom(), T_w_m, 2 * i),
               scene = viewFrom(test::largeRoom(), T_w_m * T_m_c, 2 * i + 1);
    if (shareLaid(scene, model, T_m_c) < 0.7 || scene.segments.size() < 4) continue;
    ++views;
    const Overlay overlay = overlayOf(scene, model);
    found += isNear(Eigen::Isometry3d(overlay.T_m_c.matrix().cast<double>()), T_m_c, 0.15, 4);
  }
  EXPECT_GT(views, 30);
  EXPECT_GE(found, 0.75 * views);  // others are laid over a place that looks the same
}

TEST(PlaneTripletMatcher, TheScoreIsTheShareOfThePlanesThatItLaysOnOthers) {
  Hand hand(8);
  int compared = 0;
  for (unsigned i = 0; i < 20; ++i) {
    const Eigen::Isometry3d T_w_m = hand.somewhere(), T_m_c = hand.motion();
    const View model = viewFrom(test::largeRoom(), T_w_m, 2 * i),
               scene = viewFrom(test::largeRoom(), T_w_m * T_m_c, 2 * i + 1);
    const PlaneTripletMatcher planes(scene, anywhere());
    const Overlay overlay = planes.on(PlaneColumns(model));
    if (!overlay.exists() || scene.segments.size() < 4 || scene.segments.size() > 24 ||
        model.segments.size() > 24)
      continue;
    const Eigen::Isometry3d T(overlay.T_m_c.matrix().cast<double>());
    EXPECT_THAT(Eigen::Matrix3d(T.linear().transpose() * T.linear()),
                MatrixNear(Eigen::Matrix3d::Identity(), 1e-5));
    EXPECT_NEAR(overlay.score, shareLaid(scene, model, T) - 0.02 * distanceFromPrior(T), 0.02);
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

TEST(PlaneTripletMatcher, TheSamePlaceScoresMoreThanAnother) {
  Hand hand(9);
  int better = 0;
  const Scene other = test::largeRoom() + box({2.4, 1, 0}, {3.2, 1.8, 1.2}) + box({0, 3.2, 0}, {1.4, 4, 2.2});
  for (unsigned i = 0; i < 40; ++i) {
    const Eigen::Isometry3d T_w_m = hand.somewhere(), T_w_c = T_w_m * hand.motion();
    const PlaneTripletMatcher scene(viewFrom(test::largeRoom(), T_w_c, 3 * i), anywhere());
    const float here = scene.on(PlaneColumns(viewFrom(test::largeRoom(), T_w_m, 3 * i + 1))).score,
                there = scene.on(PlaneColumns(viewFrom(other, hand.somewhere(), 3 * i + 2))).score;
    better += here > there;
  }
  EXPECT_GE(better, 30);  // 40 views in all; some show a bare corner
}

Segment plane(const Eigen::Vector3d& normal, const Eigen::Vector3d& centroid) {
  Segment s;
  s.R = rotationBetween(Eigen::Vector3d::UnitZ(), normal.normalized());
  s.t = centroid;
  s.lambda << 0.3, 0.2;
  s.num_points = 1000;
  return s;
}

View viewOf(std::vector<Segment> segments) {
  View view;
  view.segments = std::move(segments);
  return view;
}

TEST(PlaneTripletMatcher, TwoPlanesAreLaidWithTheLeastMoveAlongTheirLine) {
  const View model = viewOf({plane({1, 0, 1}, {0.5, 0, 2}), plane({-1, 0, 1}, {-0.5, 0, 2})});
  Eigen::Isometry3d T_m_c(Eigen::Translation3d(0.3, 0, -0.2));
  View scene = model;
  for (Segment& s : scene.segments) s = transformed(s, T_m_c.inverse());
  const Overlay overlay = overlayOf(scene, model);
  EXPECT_THAT(Eigen::Isometry3d(overlay.T_m_c.matrix().cast<double>()), PoseNear(T_m_c, 1e-4, 0.01));
  // A move along the line leaves the planes where they are.
  T_m_c.translation().y() = 0.4;
  for (std::size_t i = 0; i < 2; ++i) scene.segments[i] = transformed(model.segments[i], T_m_c.inverse());
  EXPECT_NEAR(overlayOf(scene, model).T_m_c.translation().y(), 0, 1e-4);
  EXPECT_GT(overlayOf(scene, model).score, 0.9);
}

TEST(PlaneTripletMatcher, ParallelPlanesAreUseless) {
  const View parallel = viewOf({plane({0, 0, 1}, {0, 0, 2}), plane({0, 0.1, 1}, {1, 0, 3})});
  EXPECT_FALSE(PlaneTripletMatcher(parallel, anywhere()).isUseful());
  EXPECT_FALSE(PlaneTripletMatcher(View{}, anywhere()).isUseful());
  EXPECT_FALSE(overlayOf(parallel, parallel).exists());
}

TEST(PlaneTripletMatcher, AMirroredPlaceIsAnother) {
  const std::vector<Segment> corner = {plane({0, 0, 1}, {0, 0, 2}), plane({1, 0, 0.3}, {0.8, 0, 2}),
                                       plane({0.5, 0.8, 0.6}, {0, 0.7, 2})};
  std::vector<Segment> mirrored = corner;
  for (Segment& s : mirrored) {
    Eigen::Vector3d n = s.normal();
    n.x() = -n.x();
    s = plane(n, {-s.t.x(), s.t.y(), s.t.z()});
  }
  EXPECT_GT(overlayOf(viewOf(corner), viewOf(corner)).score, 0.99);
  EXPECT_FALSE(overlayOf(viewOf(corner), viewOf(mirrored)).score > 0.9);
}

TEST(PlaneTripletMatcher, NonFiniteAndExcessPlanesAreLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Segment> segments = {plane({1, 0, 1}, {nan, 0, 2}), plane({1, 0, 1}, {0.5, 0, 2})};
  segments[1].lambda.x() = -1;
  const PlaneColumns columns(viewOf(segments));
  EXPECT_EQ(columns.size, 1);
  EXPECT_EQ(columns.radius[0], 0);
  EXPECT_EQ(PlaneColumns(viewOf(std::vector<Segment>(100, segments[1]))).size, PlaneColumns::kMost);
}

}  // namespace
}  // namespace facetloc
