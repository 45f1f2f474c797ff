// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include <stdexcept>
#include <string>

/** \file
 * Rotations and poses, and all that is done with their covariances. The order is (rotation, translation), in
 * radians and metres; perturbations are left and decoupled: R <- Exp(d phi) R, t <- t + d t (METHOD 1.3). */

namespace facetloc {

constexpr double kDegree = 3.14159265358979323846 / 180.0;  ///< [rad]

/** \brief Cross-product matrix: skew(a) b = a x b. */
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/** \brief Rotation matrix of a rotation vector [rad]; exact to rounding, also at zero. */
Eigen::Matrix3d expSO3(const Eigen::Vector3d& phi);

/** \brief Rotation vector of a rotation matrix [rad], norm in [0, pi]; at pi the sign of the axis is
 * arbitrary. */
Eigen::Vector3d logSO3(const Eigen::Matrix3d& R);

/** \brief Left Jacobian: Exp(phi + d) = Exp(J d) Exp(phi) to first order in d (METHOD 1.2). */
Eigen::Matrix3d leftJacobianSO3(const Eigen::Vector3d& phi);

/** \brief Angle of a rotation [rad] in [0, pi]; accurate near zero, where the trace alone is not. */
double rotationAngle(const Eigen::Matrix3d& R);

/** \brief The smallest rotation that turns one direction into another; any of them if they are opposite. */
Eigen::Matrix3d rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/** \brief A pose T_a_b and the covariance of its left, decoupled perturbation (d phi, d t) in frame a. */
struct PoseWithCovariance {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  Matrix6d P = Matrix6d::Zero();
};

/** \brief True if two poses are no farther apart than that [m, deg]. */
bool isNear(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double translation, double rotation_deg);

/** \brief T moved by a left, decoupled perturbation (d phi, d t). Its rotation stays orthonormal, however
 * often this is done. */
Eigen::Isometry3d boxplus(const Eigen::Isometry3d& T, const Vector6d& d);

/** \brief The left, decoupled perturbation that leads from T0 to T: boxplus(T0, d) = T. */
Vector6d boxminus(const Eigen::Isometry3d& T, const Eigen::Isometry3d& T0);

/** \brief Squared Mahalanobis distance of T from a pose with a positive definite covariance; chi-square of 6
 * degrees of freedom if T is exact. */
double squaredMahalanobis(const PoseWithCovariance& pose, const Eigen::Isometry3d& T);
/** \brief Squared Mahalanobis distance between two poses with independent errors. */
double squaredMahalanobis(const PoseWithCovariance& a, const PoseWithCovariance& b);

/** \brief Covariance of a left, decoupled perturbation in axes that are turned: R maps the old ones into the
 * new ones. */
Matrix6d rotateCovariance(const Eigen::Matrix3d& R, const Matrix6d& P);

/** \brief The pose of c in a, where T_a_b is exact. */
PoseWithCovariance operator*(const Eigen::Isometry3d& T_a_b, const PoseWithCovariance& T_b_c);

/** \brief The pose of c in a, of two independent poses: an error of the first one's rotation swings the way
 * of the second. */
PoseWithCovariance operator*(const PoseWithCovariance& T_a_b, const PoseWithCovariance& T_b_c);

/** \brief T_b_a of T_a_b. */
PoseWithCovariance inverse(const PoseWithCovariance& T_a_b);

/** \brief Adjoint of a rigid transform for coupled twists (phi, t): Ad(T_a_b) maps one of frame b, in its
 * axes, into the one of frame a for the same motion of a rigid body. */
Matrix6d adjoint(const Eigen::Isometry3d& T_a_b);

/** \brief Inverse of a symmetric positive definite matrix, symmetric to the last bit. */
Matrix6d symmetricInverse(const Matrix6d& A);

/** \brief Standard deviation along the direction in which it is largest. */
double largestStd(const Eigen::Matrix3d& covariance);
/** \brief Largest standard deviation of the orientation [rad], about any axis, and of the position [m]. */
double largestRotationStd(const Matrix6d& P);
double largestTranslationStd(const Matrix6d& P);

/** \brief How well a pose is known along its principal directions, of rotation and of translation separately;
 * in ascending order. */
struct PrincipalStd {
  Eigen::Vector3d rotation = Eigen::Vector3d::Constant(1e6);       ///< [rad]
  Eigen::Matrix3d rotation_axes = Eigen::Matrix3d::Identity();     ///< columns, in frame a
  Eigen::Vector3d translation = Eigen::Vector3d::Constant(1e6);    ///< [m]
  Eigen::Matrix3d translation_axes = Eigen::Matrix3d::Identity();  ///< columns, in frame a

  /** \brief True if no direction is less certain than that [rad, m]. */
  bool within(double max_rotation, double max_translation) const {
    return rotation[2] <= max_rotation && translation[2] <= max_translation;
  }
  /** \brief True if orientation and two translations are as certain as that, and the third is not. */
  bool oneTranslationFree(double max_rotation, double max_translation) const {
    return rotation[2] <= max_rotation && translation[1] <= max_translation &&
           translation[2] > max_translation;
  }
};
PrincipalStd principalStd(const Matrix6d& P);

/** \brief The motions that are less certain than this [rad, m], in words, such as "rotation about (0.00,
 * 1.00, 0.00), translation along (1.00, 0.02, 0.00)"; empty if all are certain. \param R turns axes of frame
 * a into those of the words. */
std::string freeMotions(const PrincipalStd& known, double max_rotation, double max_translation,
                        const Eigen::Matrix3d& R = Eigen::Matrix3d::Identity());

/** \brief The squared Mahalanobis distance that an error of n degrees of freedom does not exceed with this
 * probability, to four digits or more; of a constant of another pair the compiler complains.
 *
 *     constexpr double kGate = chiSquareQuantile(3, 0.99);
 *
 * \throws std::invalid_argument for a pair that is not in the table */
constexpr double chiSquareQuantile(int degrees_of_freedom, double probability) {
  struct Quantile {
    int degrees_of_freedom;
    double probability, value;
  };
  constexpr Quantile kTable[] = {
      {3, 0.95, 7.81}, {3, 0.99, 11.345}, {6, 0.95, 12.59}, {6, 0.99, 16.81}, {6, 0.999, 22.46}};
  for (const Quantile& q : kTable)
    if (q.degrees_of_freedom == degrees_of_freedom && q.probability == probability) return q.value;
  throw std::invalid_argument("no quantile of chi-square is known for this probability");
}

}  // namespace facetloc
