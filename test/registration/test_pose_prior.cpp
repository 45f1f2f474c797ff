// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {
namespace {

using test::gaussian, test::IsPositiveSemidefinite, test::MatrixNear, test::Rng;

TEST(PosePrior, WithoutAMountingIsIsotropic) {
  PosePriorParams params;
  params.rotation_std_deg = 60, params.translation_std = 1.5;
  const Matrix6d P = posePrior({}, params);
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(std::pow(60 * kDegree, 2)), Eigen::Vector3d::Constant(2.25);
  EXPECT_THAT(P, MatrixNear(Matrix6d(variance.asDiagonal()), 1e-15));
}

TEST(PosePrior, OfAnOdometryGrowsWithTheDistance) {
  Eigen::Isometry3d motion(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
  motion.translation() << 0, 0, 0.4;
  const OdometryError error{0.03, 2, 0.001, 0.1};
  const PoseWithCovariance free = motionByOdometry(motion, {}, error);
  EXPECT_EQ(free.T.matrix(), motion.matrix());
  // 3 % of the distance, correlated over 10 m; 2 deg per root of a metre, of which 0.5 rad are 0.1 m.
  EXPECT_NEAR(largestTranslationStd(free.P), 0.03 * std::sqrt(0.4 * 10) + 0.001, 1e-9);
  EXPECT_NEAR(largestRotationStd(free.P), (2 * std::sqrt(0.5) + 0.1) * kDegree, 1e-9);
  // Many steps add up to the variance of one long one.
  double variance = 0;
  Eigen::Isometry3d step(Eigen::Translation3d(0, 0, 0.1));
  for (int i = 0; i < 100; ++i)
    variance += std::pow(largestTranslationStd(motionByOdometry(step, {}, {0.03, 2, 0, 0.01}).P), 2);
  EXPECT_NEAR(std::sqrt(variance), 0.03 * 10, 1e-9);
  // A robot's wheels roll in the plane of the floor: across it, only the floor's unevenness counts.
  step.translation().z() = 1;
  const Matrix6d P = motionByOdometry(step, CameraMounting{1, 0}, error).P;  // a level camera: y is down
  const double along = 0.03 * std::sqrt(10) + 0.001;  // and the effect of the floor on a camera 1 m above it
  EXPECT_GT(std::sqrt(P(5, 5)), along);
  EXPECT_LT(std::sqrt(P(5, 5)), 1.2 * along);
  EXPECT_LT(P(4, 4), 0.25 * P(5, 5));
}

TEST(PosePrior, OfALevelCameraOnAFlatFloorIsHeadingAndPlanarMotion) {
  PosePriorParams params;
  params.robot.floor_std = 0;
  const Matrix6d P = posePrior(CameraMounting{0, 0}, params);
  Vector6d variance = Vector6d::Zero();  // camera axes: x right, y down, z forward
  variance[1] = std::pow(20 * kDegree, 2);
  variance[3] = variance[5] = 1;
  // No floor is flatter than a micrometre under each wheel, so that covariances are regular.
  const Eigen::Matrix3d C = floorCovariance(params);
  EXPECT_NEAR(C(2, 2), 0.5e-12, 1e-18);
  Matrix6d want = variance.asDiagonal();
  want(0, 0) = 2 * C(1, 1);
  want(2, 2) = 2 * C(0, 0);
  want(4, 4) = 2 * C(2, 2) + C(0, 0) + C(1, 1);
  want(0, 4) = want(4, 0) = 2 * C(1, 2);
  EXPECT_THAT(P, MatrixNear(want, 1e-12));
}

TEST(PosePrior, FloorTiltsHaveTheSizesOfThePaper) {
  const Eigen::Matrix3d C = 2 * floorCovariance({});  // under the scene and under the model pose
  EXPECT_NEAR(std::sqrt(C(0, 0)) / kDegree, 1.76, 0.005);
  EXPECT_NEAR(std::sqrt(C(1, 1)) / kDegree, 3.01, 0.005);
  EXPECT_NEAR(std::sqrt(C(2, 2)), 0.005, 1e-12);
}

TEST(PosePrior, FloorCovarianceIsThatOfThreeWheels) {
  // A plane through the feet of three wheels at independent heights.
  const PosePriorParams p;
  const RobotParams& robot = p.robot;
  Rng rng(1);
  Eigen::Matrix3d sampled = Eigen::Matrix3d::Zero();
  constexpr int kTrials = 200000;
  for (int i = 0; i < kTrials; ++i) {
    const Eigen::Vector3d f = robot.floor_std * gaussian<3>(rng);
    Eigen::Matrix3d A;  // z = z0 + gx x + gy y at the left, the right wheel and the caster
    A << 1, 0, robot.wheel_track / 2, 1, 0, -robot.wheel_track / 2, 1, -robot.caster_distance, 0;
    const Eigen::Vector3d plane = A.inverse() * f, q(plane[2], -plane[1], plane[0]);
    sampled += q * q.transpose() / kTrials;
  }
  const Eigen::Matrix3d C = floorCovariance(p);
  const Eigen::Vector3d scale = C.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_THAT((scale.asDiagonal() * (sampled - C) * scale.asDiagonal()).eval(),
              MatrixNear(Eigen::Matrix3d::Zero().eval(), 0.02));
}

TEST(PosePrior, IsTheFloorsInformationAndTheRangeOfHeadingAndPlace) {
  const CameraMounting mounting{1.2, 20};
  PosePriorParams p;
  p.rotation_std_deg = 5, p.translation_std = 0.2;
  const Matrix6d A = cameraMotion(mounting);
  const Matrix6d rest = posePrior(mounting, p).inverse() - floorInformation(mounting, p);
  Vector6d want = Vector6d::Zero();  // pose of the base: heading, then the place
  want[2] = 1 / std::pow(5 * kDegree, 2);
  want[3] = want[4] = 25;
  EXPECT_THAT(Matrix6d(A.transpose() * rest * A), MatrixNear(Matrix6d(want.asDiagonal()), 1e-6));
  EXPECT_EQ(floorInformation({}, p), Matrix6d::Zero());
}

TEST(PosePrior, TheCameraMovesAsItsRobotDoes) {
  const CameraMounting mounting{1.2, 20};
  const Eigen::Isometry3d T_b_c = mounting.T_b_c();
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Isometry3d moved = boxplus(Eigen::Isometry3d::Identity(), kStep * Vector6d::Unit(i));
    const Vector6d seen = boxminus(T_b_c.inverse() * moved * T_b_c, Eigen::Isometry3d::Identity());
    EXPECT_THAT(Vector6d(cameraMotion(mounting).col(i)), MatrixNear(Vector6d(seen / kStep), 1e-5)) << i;
  }
}

// The exact composition T_m_c = (floor_m T_b_c)^-1 motion floor_c T_b_c, sampled.
class SampledPoses {
public:
  SampledPoses(const CameraMounting& mounting, const PosePriorParams& p, int seed)
      : T_b_c_(mounting.T_b_c()), p_(p), rng_(seed) {}

  // About a displacement of the robot; nothing is known of its true pose but how far it may be from there.
  Eigen::Isometry3d next(const Eigen::Isometry3d& T_m_b = Eigen::Isometry3d::Identity()) {
    Eigen::Isometry3d motion = T_m_b;
    motion.linear() = T_m_b.linear() * expSO3({0, 0, p_.rotation_std_deg * kDegree * gaussian<1>(rng_)[0]});
    motion.translation().head<2>() += p_.translation_std * gaussian<2>(rng_);
    const Eigen::Isometry3d T_m = onTheFloor(), T_s = onTheFloor();
    return (T_m * T_b_c_).inverse() * motion * T_s * T_b_c_;
  }

private:
  Eigen::Isometry3d onTheFloor() {
    const Eigen::Vector3d f = p_.robot.floor_std * gaussian<3>(rng_);
    const double z0 = (f[0] + f[1]) / 2, gy = (f[0] - f[1]) / p_.robot.wheel_track,
                 gx = (z0 - f[2]) / p_.robot.caster_distance;
    return Eigen::Translation3d(0, 0, z0) * Eigen::Isometry3d(expSO3({gy, -gx, 0}));
  }

  Eigen::Isometry3d T_b_c_;
  PosePriorParams p_;
  Rng rng_;
};

// Far away, the effect of tilts of the model's robot on the height is larger than the floor's.
TEST(PosePrior, PropagatesTheFloorThroughTheMounting) {
  PosePriorParams p;
  p.rotation_std_deg = 1, p.robot.floor_std = 0.002;
  const CameraMounting mounting{1.2, 20};
  const Eigen::Isometry3d T_b_c = mounting.T_b_c();
  const Eigen::Isometry3d away = Eigen::Translation3d(0.7, -1.1, 0) * Eigen::Isometry3d(expSO3({0, 0, 0.5}));
  for (const double translation_std : {0.05, 0.4})
    for (const Eigen::Isometry3d& T_m_b : {Eigen::Isometry3d(Eigen::Isometry3d::Identity()), away}) {
      p.translation_std = translation_std;
      const Eigen::Isometry3d expected = T_b_c.inverse() * T_m_b * T_b_c;
      const Matrix6d P = posePrior(mounting, p, expected);
      EXPECT_THAT(P, IsPositiveSemidefinite(1e-12));
      SampledPoses poses(mounting, p, 2);
      Matrix6d sampled = Matrix6d::Zero();
      constexpr int kTrials = 200000;
      for (int i = 0; i < kTrials; ++i) {
        const Vector6d e = boxminus(poses.next(T_m_b), expected);
        sampled += e * e.transpose() / kTrials;
      }
      EXPECT_LT((sampled - P).norm() / P.norm(), 0.02);
      // The same for every component beside its own size, not only for the large ones.
      const Vector6d scale = P.diagonal().cwiseSqrt().cwiseInverse();
      EXPECT_LT((scale.asDiagonal() * (sampled - P) * scale.asDiagonal()).cwiseAbs().maxCoeff(), 0.02);
    }
}

TEST(PosePrior, TruePosesLieWithinThePriorOfThePaper) {
  constexpr double kChi2At99Percent = chiSquareQuantile(6, 0.99);
  constexpr int kTrials = 20000;
  const CameraMounting mounting{1, 10};
  const Eigen::LDLT<Matrix6d> P(posePrior(mounting));
  SampledPoses poses(mounting, {}, 3);
  double mean = 0;
  int inside = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Vector6d e = boxminus(poses.next(), Eigen::Isometry3d::Identity());
    const double squared = e.dot(P.solve(e));
    mean += squared / kTrials;
    inside += squared < kChi2At99Percent;
  }
  EXPECT_NEAR(mean, 6, 0.5);
  EXPECT_GT(inside, 0.97 * kTrials);
}

TEST(PosePrior, ATiltedCameraRollsWhenTheRobotTurns) {
  const Matrix6d P = posePrior(CameraMounting{1, 30});
  EXPECT_GT(P(2, 2), std::pow(0.9 * 20 * std::sin(30 * kDegree) * kDegree, 2));
}

}  // namespace
}  // namespace facetloc
