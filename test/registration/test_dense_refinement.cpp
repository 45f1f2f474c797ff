// SPDX-License-Identifier: BSD-3-Clause
#include "depth/dense_refinement.h"
#include "depth/depth_consistency.h"
#include "depth/depth_difference.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace facetloc {
namespace {

using namespace internal;
using test::lookingAlong, test::MatrixNear, test::PoseNear;

const double kNoise = SensorNoise{}.inverse_depth_std;

DepthPicture pictureOf(const test::Scene& scene, const Eigen::Isometry3d& T_w_c, unsigned seed) {
  return DepthPicture::fromDepth(
      test::noisy(test::render(scene, test::smallCamera(), T_w_c, 8).image, kNoise, seed));
}

Matrix6d priorCovariance(double rotation_std, double translation_std) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(rotation_std * rotation_std),
      Eigen::Vector3d::Constant(translation_std * translation_std);
  return variance.asDiagonal();
}

class DenseRefinement : public testing::Test {
protected:
  DenseRefinement() {
    for (const double x : {2.2, 2.9}) cameras.push_back(lookingAlong({x, 1.4, 1.2}, {0.2, 1, -0.3}));
    for (std::size_t i = 0; i < cameras.size(); ++i)
      depth.push_back(pictureOf(test::largeRoom(), cameras[i], static_cast<unsigned>(10 + i)));
  }
  std::vector<PosedPicture> pictures() const { return {{&depth[0], cameras[0]}, {&depth[1], cameras[1]}}; }
  bool refine(PoseWithCovariance& pose) const { return refineByDepth(scene, pictures(), params, pose); }

  const Eigen::Isometry3d truth = lookingAlong({2.6, 1.7, 1.25}, {0.1, 1, -0.25});
  std::vector<Eigen::Isometry3d> cameras;
  std::vector<DepthPicture> depth;
  DepthPicture scene = pictureOf(test::largeRoom(), truth, 1);
  DenseRefinementParams params;
};

TEST_F(DenseRefinement, FindsTheTruthFromNearIt) {
  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 20; ++trial) {
    Vector6d d;
    for (int i = 0; i < 6; ++i) d[i] = (i < 3 ? 0.5 * kDegree : 0.02) * normal(rng);
    PoseWithCovariance pose{boxplus(truth, d), priorCovariance(0.5 * kDegree, 0.02)};
    ASSERT_TRUE(refine(pose));
    EXPECT_LT((pose.T.translation() - truth.translation()).norm(), 0.005) << trial;
    EXPECT_LT(rotationAngle(pose.T.linear() * truth.linear().transpose()), 0.1 * kDegree) << trial;
  }
}

// Normal equations of all pixels, one by one and in double precision.
struct Sums {
  Matrix6d A = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
};
Sums ofAllPixels(const DepthPicture& scene, const std::vector<PosedPicture>& pictures,
                 const Eigen::Isometry3d& T_w_c, const Matrix6d& uncertainty, double error, double gate) {
  Sums sums;
  const int step = gridStep(scene, kFineColumns);
  for (const PosedPicture& p : pictures) {
    const Eigen::Isometry3d T_m_c = p.T_w_c.inverse() * T_w_c;
    for (int v = step / 2; v < scene.camera.height; v += step)
      for (int u = step / 2; u < scene.camera.width; u += step) {
        const double rho = DepthPicture::kQuantum * scene.inverse_depth[v * scene.camera.width + u];
        const Eigen::Vector3d ray = scene.camera.ray(u, v);
        DepthDifference d;
        if (rho < 1 / 8.0 ||
            !compareDepth(T_m_c.linear() * ray, T_m_c.translation(), rho, *p.picture, error, d))
          continue;
        const Eigen::Vector3d a = p.T_w_c.linear() * d.by_point, arm = T_w_c.linear() * ray / rho;
        Vector6d J;
        J << arm.cross(a), a;
        const double largest = gate * std::sqrt(error * error + J.dot(uncertainty * J));
        if (std::abs(d.residual) >= largest) continue;
        const double weight = std::pow(1 - std::pow(d.residual / largest, 2), 2);
        sums.A += weight * J * J.transpose();
        sums.g += weight * d.residual * J;
      }
  }
  return sums;
}

TEST_F(DenseRefinement, AStepIsThatOfAllPixelsOneByOne) {
  params.iterations = 1, params.significance = 0;
  const double error = params.pixel_error * kNoise, of_pixel = 1 / (error * error * params.correlated_pixels);
  std::mt19937 rng(6);
  std::normal_distribution<double> normal;
  // A pixel on the border of the compared area may fall to the other side in single precision: one of a
  // thousand.
  int exact = 0;
  for (int trial = 0; trial < 10; ++trial) {
    Vector6d d;
    for (int i = 0; i < 6; ++i) d[i] = (i < 3 ? 0.5 * kDegree : 0.02) * normal(rng);
    const PoseWithCovariance start{boxplus(truth, d), priorCovariance(0.5 * kDegree, 0.02)};
    const Sums first = ofAllPixels(scene, pictures(), start.T, start.P, error, params.robust_gate);
    const Matrix6d A = of_pixel * first.A + start.P.inverse();
    const Eigen::Isometry3d stepped = boxplus(start.T, -A.ldlt().solve(of_pixel * first.g));

    PoseWithCovariance pose = start;
    Matrix6d information;
    ASSERT_TRUE(refineByDepth(scene, pictures(), params, pose, &information));
    EXPECT_THAT(pose.T, PoseNear(stepped, 1e-4, 5e-3)) << trial;
    const Vector6d apart = boxminus(pose.T, stepped);
    exact += apart.head<3>().norm() < 1e-5 && apart.tail<3>().norm() < 1e-5;
    const Matrix6d there =
        of_pixel * ofAllPixels(scene, pictures(), pose.T, 0.25 * start.P, error, params.robust_gate).A;
    EXPECT_THAT(information, MatrixNear(there, 3e-3 * there.norm())) << trial;
  }
  EXPECT_GE(exact, 8);
}

TEST_F(DenseRefinement, LeavesTheCovarianceAsItIs) {
  // The pixels are those that the planes were fitted to: they are not a second measurement.
  PoseWithCovariance pose{truth, priorCovariance(1 * kDegree, 0.05)};
  const Matrix6d before = pose.P;
  ASSERT_TRUE(refine(pose));
  EXPECT_EQ(pose.P, before);
}

TEST_F(DenseRefinement, IsNotMisledByMovedObjects) {
  // A board that no picture saw covers a quarter of the scene.
  const test::Scene changed = test::largeRoom() + test::box({1.2, 2.6, 0}, {2.3, 2.9, 2.5});
  scene = pictureOf(changed, truth, 1);
  PoseWithCovariance pose{truth, priorCovariance(1 * kDegree, 0.05)};
  pose.T.translation() += Eigen::Vector3d(0.01, -0.01, 0.01);
  ASSERT_TRUE(refine(pose));
  EXPECT_LT((pose.T.translation() - truth.translation()).norm(), 0.005);
}

TEST_F(DenseRefinement, KeepsThePriorWhereThePixelsSayNothing) {
  // One wall: it fixes its distance and two rotations, and nothing else.
  const test::Scene wall{test::endlessPlane({0, 3, 0}, {0, -1, 0})};
  const Eigen::Isometry3d here = lookingAlong({0, 1, 1.2}, {0, 1, 0});
  scene = pictureOf(wall, here, 1);
  const DepthPicture model = pictureOf(wall, here, 2);
  PoseWithCovariance pose{here, priorCovariance(2 * kDegree, 0.05)};
  pose.T.translation() += Eigen::Vector3d(0.03, 0.02, -0.03);
  ASSERT_TRUE(refineByDepth(scene, {{&model, here}}, params, pose));
  const Eigen::Vector3d off = pose.T.translation() - here.translation();
  EXPECT_NEAR(off.x(), 0.03, 0.01);  // a fifth of the prior's deviation
  EXPECT_NEAR(off.y(), 0, 1e-3);
  EXPECT_NEAR(off.z(), -0.03, 0.01);
}

TEST_F(DenseRefinement, GivesTheInformationOfThePixels) {
  // Errors of white noise in the scene's pixels: of variance 1 + 1/5 instead of pixel_error^2, as the model's
  // pixels are averaged and the same each time.
  constexpr int kTrials = 40;
  double squares = 0;
  Vector6d mean = Vector6d::Zero();
  std::vector<Vector6d> errors;
  Matrix6d information;
  for (int i = 0; i < kTrials; ++i) {
    scene = pictureOf(test::largeRoom(), truth, static_cast<unsigned>(100 + i));
    PoseWithCovariance pose{truth, priorCovariance(5 * kDegree, 0.5)};
    ASSERT_TRUE(refineByDepth(scene, pictures(), params, pose, &information));
    errors.push_back(boxminus(pose.T, truth));
    mean += errors.back() / kTrials;
  }
  for (const Vector6d& e : errors) squares += (e - mean).dot(information * (e - mean)) / (kTrials - 1);
  EXPECT_GT(squares, 6 / std::pow(params.pixel_error, 2) / 2);
  EXPECT_LT(squares, 6);
}

TEST_F(DenseRefinement, ABareWallFeignsNoInformation) {
  const Eigen::Isometry3d here = lookingAlong({0, 0, 1.2}, {0.1, 1, -0.1});
  scene = pictureOf(test::endlessCorridor(), here, 1);
  const DepthPicture model = pictureOf(test::endlessCorridor(), here, 2);
  const PoseWithCovariance prior{here, priorCovariance(2 * kDegree, 0.05)};
  const auto stdAlong = [&](double significance) {
    params.significance = significance;
    PoseWithCovariance pose = prior;
    Matrix6d information;
    EXPECT_TRUE(refineByDepth(scene, {{&model, here}}, params, pose, &information));
    const Matrix6d P = (information + prior.P.inverse()).inverse();
    EXPECT_LT(P(3, 3), 1e-3 * prior.P(3, 3));  // across, the walls tell
    return std::sqrt(P(4, 4));
  };
  EXPECT_LT(stdAlong(0), 0.02);  // feigned by the noise of the gradients
  EXPECT_GT(stdAlong(4), 0.045);
  for (const double less : {0.01, 0.5}) EXPECT_EQ(stdAlong(less), stdAlong(1));  // never less than nothing
}

TEST_F(DenseRefinement, DoesNotDependOnTheWorldFrame) {
  PoseWithCovariance pose{truth, priorCovariance(1 * kDegree, 0.05)};
  pose.T.translation() += Eigen::Vector3d(0.02, 0.01, -0.01);
  const Eigen::Isometry3d T_v_w =
      Eigen::Translation3d(5, -7, 1) * Eigen::Isometry3d(expSO3({0.3, -1.1, 2.0}));
  PoseWithCovariance moved{T_v_w * pose.T, pose.P};
  std::vector<PosedPicture> there = pictures();
  for (PosedPicture& p : there) p.T_w_c = T_v_w * p.T_w_c;
  ASSERT_TRUE(refine(pose));
  ASSERT_TRUE(refineByDepth(scene, there, params, moved));
  EXPECT_TRUE((T_v_w * pose.T).isApprox(moved.T, 1e-6));
}

TEST_F(DenseRefinement, WithoutSharedPixelsChangesNothing) {
  const PoseWithCovariance start{truth, priorCovariance(1 * kDegree, 0.05)};
  const auto expectNone = [&](const DepthPicture& s, const std::vector<PosedPicture>& p) {
    PoseWithCovariance pose = start;
    EXPECT_FALSE(refineByDepth(s, p, params, pose));
    EXPECT_EQ(pose.T.matrix(), start.T.matrix());
  };
  expectNone({}, pictures());
  expectNone(scene, {});
  const DepthPicture empty;
  expectNone(scene, {{&empty, truth}});
  expectNone(scene, {{&depth[0], lookingAlong({2.6, 1.7, 1.25}, {0, -1, 0})}});
  PoseWithCovariance singular{truth, Matrix6d::Zero()};
  EXPECT_FALSE(refine(singular));
}

}  // namespace
}  // namespace facetloc
