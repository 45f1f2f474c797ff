// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/floor_update.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace facetloc {
namespace {

using test::gaussian;
using test::IsPositiveSemidefinite;
using test::MatrixNear;
using test::PoseNear;
using test::Rng;

const CameraMounting kMounting{1.2, 15};

/** A camera whose robot stands at (x, y, z) with that (roll, pitch, heading) [rad]. */
Eigen::Isometry3d standing(const Eigen::Vector3d& place, const Eigen::Vector3d& angles) {
  Eigen::Isometry3d T_w_b = Eigen::Isometry3d::Identity();
  T_w_b.linear() = expSO3({0, 0, angles.z()}) * expSO3({angles.x(), angles.y(), 0});
  T_w_b.translation() = place;
  return T_w_b * kMounting.T_b_c();
}

/** Roll, pitch and height of that camera's robot on the floor z = 0, without any approximation but small
 * tilts.
 */
Eigen::Vector3d ofTheRobot(const Eigen::Isometry3d& T_w_c) {
  const Eigen::Isometry3d T_w_b = T_w_c * kMounting.T_b_c().inverse();
  const Eigen::Vector3d x = T_w_b.linear().col(0), y = T_w_b.linear().col(1);
  return {y.z(), -x.z(), T_w_b.translation().z()};
}

TEST(FloorUpdate, TheFloorIsThatOfTheRobots) {
  const FloorPlane one = floorUnder({standing({1, 2, 0.3}, {0, 0, 1})}, kMounting);
  EXPECT_THAT(one.normal, MatrixNear(Eigen::Vector3d(0, 0, 1), 1e-12));
  EXPECT_NEAR(one.distance, 0.3, 1e-12);
  // Tilts that cancel, heights that are averaged.
  const FloorPlane two =
      floorUnder({standing({1, 2, 0.1}, {0.1, 0, 0.5}), standing({3, 2, 0.2}, {-0.1, 0, 0.5})}, kMounting);
  EXPECT_THAT(two.normal, MatrixNear(Eigen::Vector3d(0, 0, 1), 1e-12));
  EXPECT_NEAR(two.distance, 0.15, 1e-12);
}

TEST(FloorUpdate, APoseThatIsNotKnownOtherwiseIsPutOnTheFloor) {
  PoseWithCovariance camera;
  camera.T = standing({1, 2, 0.05}, {0.02, -0.03, 0.7});
  camera.P = 100 * Matrix6d::Identity();
  const Eigen::Matrix3d covariance = 1e-8 * Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) {  // linear in small angles only
    camera = updatedByFloor(camera, kMounting, {}, covariance);
    camera.P = 100 * Matrix6d::Identity();
  }
  EXPECT_THAT(ofTheRobot(camera.T), MatrixNear(Eigen::Vector3d::Zero().eval(), 1e-6));
}

TEST(FloorUpdate, IsTheInformationFilterOfTheNumericJacobian) {
  Rng rng(3);
  const Eigen::Matrix3d covariance = floorCovariance({});
  for (int trial = 0; trial < 20; ++trial) {
    const Vector6d g = gaussian<6>(rng);
    PoseWithCovariance prior;
    prior.T = standing({g[0], g[1], 0.004 * g[2]}, {0.004 * g[3], 0.004 * g[4], g[5]});
    Matrix6d L = Matrix6d::Zero();
    for (int i = 0; i < 6; ++i) L.col(i) = 0.03 * gaussian<6>(rng);
    prior.P = L * L.transpose() + 1e-6 * Matrix6d::Identity();

    constexpr double kStep = 1e-6;
    Eigen::Matrix<double, 3, 6> H;
    for (int i = 0; i < 6; ++i)
      H.col(i) = (ofTheRobot(perturbed(prior.T, kStep * Vector6d::Unit(i))) -
                  ofTheRobot(perturbed(prior.T, -kStep * Vector6d::Unit(i)))) /
                 (2 * kStep);
    const Matrix6d P = (prior.P.inverse() + H.transpose() * covariance.inverse() * H).inverse();
    const Vector6d step = -P * H.transpose() * covariance.inverse() * ofTheRobot(prior.T);

    const PoseWithCovariance found = updatedByFloor(prior, kMounting, {}, covariance);
    EXPECT_THAT(found.P, MatrixNear(P, 1e-6 * P.norm())) << trial;
    EXPECT_THAT(found.P, IsPositiveSemidefinite(1e-12)) << trial;
    EXPECT_THAT(perturbation(prior.T, found.T), MatrixNear(step, 1e-6)) << trial;
  }
}

TEST(FloorUpdate, DoesNotDependOnTheAxesOfTheWorld) {
  Eigen::Isometry3d T_v_w = Eigen::Isometry3d::Identity();
  T_v_w.linear() = expSO3({1, -0.5, 2});
  T_v_w.translation() << 3, -1, 4;
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = T_v_w.linear();

  PoseWithCovariance camera;
  camera.T = standing({1, 2, 0.004}, {0.01, -0.02, 0.7});
  camera.P = 1e-3 * Matrix6d::Identity();
  const Eigen::Isometry3d mapped = standing({0, 0, 0}, {0, 0, 0});
  const Eigen::Matrix3d covariance = floorCovariance({});
  const PoseWithCovariance there =
      updatedByFloor(camera, kMounting, floorUnder({mapped}, kMounting), covariance);
  const PoseWithCovariance here =
      updatedByFloor({T_v_w * camera.T, turn * camera.P * turn.transpose()}, kMounting,
                     floorUnder({T_v_w * mapped}, kMounting), covariance);
  EXPECT_THAT(here.T, PoseNear(T_v_w * there.T, 1e-9, 1e-7));
  EXPECT_THAT(here.P, MatrixNear(Matrix6d(turn * there.P * turn.transpose()), 1e-12));
}

}  // namespace
}  // namespace facetloc
