// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/local_model.h>
#include <facetloc/testing/random_segments.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gmock/gmock.h>

#include <algorithm>
#include <memory>

namespace facetloc {
namespace {

using test::rectangle, test::Rng;

using Matrix36d = Eigen::Matrix<double, 3, 6>;

/** The disturbance of a measured plane from a true one, in the frame of the measured one. */
Eigen::Vector3d disturbance(const Segment& measured, const Segment& truth) {
  const Eigen::Vector3d n = measured.R.transpose() * truth.normal();
  return {n.x() / n.z(), n.y() / n.z(), n.dot(measured.R.transpose() * (truth.t - measured.t)) / n.z()};
}

/** Derivative of a segment's disturbance by the pose that moves its plane. */
Matrix36d jacobian(const Segment& in_camera, const Eigen::Isometry3d& T) {
  constexpr double kStep = 1e-6;
  const Segment here = transformed(in_camera, T);
  Matrix36d J;
  for (int k = 0; k < 6; ++k) {
    const Vector6d step = kStep * Vector6d::Unit(k);
    J.col(k) = (disturbance(here, transformed(in_camera, boxplus(T, step))) -
                disturbance(here, transformed(in_camera, boxplus(T, -step)))) /
               (2 * kStep);
  }
  return J;
}

std::vector<Segment> room() {
  std::vector<Segment> all;
  for (const double turn : {0.0, 0.4}) {
    all.push_back(rectangle({0.3, 0.2, 3 + turn}, {0.1, 0, 1}, 1, 0.8, turn, 0.003, 0.004));
    all.push_back(rectangle({1.5 + turn, 0, 2}, {1, 0.1, 0.2}, 1, 0.5, turn, 0.006, 0.005));
    all.push_back(rectangle({0, 1 + turn, 2.5}, {0, 1, 0.2}, 1, 0.5, turn, 0.004, 0.006));
  }
  return all;
}

View viewWith(std::vector<Segment> segments) {
  View view;
  view.segments = std::move(segments);
  return view;
}

PoseWithCovariance mounting(double rotation_std, double translation_std) {
  Vector6d std;
  std << Eigen::Vector3d::Constant(rotation_std), Eigen::Vector3d::Constant(translation_std);
  Eigen::Isometry3d T(Eigen::AngleAxisd(2.2, Eigen::Vector3d(0.1, 1, 0.2).normalized()));
  T.translation() = Eigen::Vector3d(-0.2, 0.05, -0.3);
  return {T, std.cwiseAbs2().asDiagonal()};
}

TEST(JoinedView, HasTheSegmentsAndPicturesOfAllImages) {
  const View first = viewWith({rectangle({0, 0, 2}, {0, 0, 1}, 1, 1)});
  auto other = std::make_shared<View>(viewWith({rectangle({0, 0.5, 3}, {0, 0.1, 1}, 1, 1)}));
  other->depth = DepthPicture::fromStored({2, 1, 2, 2, 0.5, 0}, {8000, 9000});
  const PoseWithCovariance T_v_c = mounting(0, 0);
  const View all = joined(first, {{other, T_v_c}});
  ASSERT_EQ(all.segments.size(), 2u);
  const Segment moved = transformed(other->segments.front(), T_v_c.T);
  EXPECT_TRUE(std::any_of(all.segments.begin(), all.segments.end(),
                          [&](const Segment& s) { return test::sameNumbers(s, moved); }));
  ASSERT_EQ(all.sides.size(), 1u);
  EXPECT_EQ(all.sides.front().picture.get(), &other->depth);
  EXPECT_TRUE(all.sides.front().T_v_c.isApprox(T_v_c.T));
  EXPECT_TRUE(joined(first, {}).sides.empty());
}

// A pose that is estimated from segments as if their errors were independent: its stated covariance bounds
// the true one, which has the common error, without being much larger.
TEST(JoinedView, SegmentsTogetherKnowNoMoreThanTheCalibrationOfTheirCamera) {
  for (const double size : {0.2, 1.0, 5.0}) {
    const PoseWithCovariance T_v_c = mounting(size * 0.01, size * 0.02);
    const std::vector<Segment> own = room();
    const View all = joined({}, {{std::make_shared<View>(viewWith(own)), T_v_c}});
    ASSERT_EQ(all.segments.size(), own.size());
    Matrix6d stated = Matrix6d::Zero(), exact = Matrix6d::Zero();  // informations
    std::vector<Matrix36d> J;
    for (const Segment& s : own) {
      const Segment here = transformed(s, T_v_c.T);
      const auto found = std::find_if(all.segments.begin(), all.segments.end(),
                                      [&](const Segment& o) { return o.t.isApprox(here.t); });
      ASSERT_NE(found, all.segments.end());
      J.push_back(jacobian(s, T_v_c.T));
      stated += J.back().transpose() * found->Sigma_q.inverse() * J.back();
      exact += J.back().transpose() * s.Sigma_q.inverse() * J.back();
    }
    const Matrix6d bound = stated.inverse(), truth = exact.inverse() + T_v_c.P;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d> ratio(bound, truth);
    EXPECT_GE(ratio.eigenvalues().minCoeff(), 1 - 1e-6) << size;
    EXPECT_LE(ratio.eigenvalues().maxCoeff(), 4) << size;
  }
}

}  // namespace
}  // namespace facetloc
