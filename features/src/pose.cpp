// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace facetloc {
namespace {

// A direction whose sign means nothing: its largest component is shown positive.
std::string directionText(const Eigen::Vector3d& v) {
  int largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  const Eigen::Vector3d d = v[largest] < 0 ? Eigen::Vector3d(-v) : v;
  // Adding zero makes -0 positive.
  const auto rounded = [&](int i) { return std::round(100 * d[i]) / 100 + 0.0; };
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", rounded(0), rounded(1), rounded(2));
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Eigen::Matrix3d expSO3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  if (angle < 1e-9) return Eigen::Matrix3d::Identity() + skew(phi);
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

Eigen::Vector3d logSO3(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd a(R);
  return a.angle() * a.axis();
}

Eigen::Matrix3d leftJacobianSO3(const Eigen::Vector3d& phi) {
  const double f = phi.norm();
  const Eigen::Matrix3d K = skew(phi);
  if (f < 1e-5) return Eigen::Matrix3d::Identity() + 0.5 * K + K * K / 6.0;
  return Eigen::Matrix3d::Identity() + (1 - std::cos(f)) / (f * f) * K +
         (f - std::sin(f)) / (f * f * f) * K * K;
}

double rotationAngle(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d twice_sine_axis(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  return std::atan2(0.5 * twice_sine_axis.norm(), 0.5 * (R.trace() - 1.0));
}

Eigen::Matrix3d rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

Matrix6d rotateCovariance(const Eigen::Matrix3d& R, const Matrix6d& P) {
  Matrix6d out;
  for (const int row : {0, 3})
    for (const int column : {0, 3})
      out.block<3, 3>(row, column) = R * P.block<3, 3>(row, column) * R.transpose();
  return out;
}

PoseWithCovariance operator*(const Eigen::Isometry3d& T_a_b, const PoseWithCovariance& T_b_c) {
  return {T_a_b * T_b_c.T, rotateCovariance(T_a_b.linear(), T_b_c.P)};
}

bool isNear(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double translation, double rotation_deg) {
  return (a.translation() - b.translation()).norm() <= translation &&
         rotationAngle(a.linear() * b.linear().transpose()) <= rotation_deg * kDegree;
}

Eigen::Isometry3d boxplus(const Eigen::Isometry3d& T, const Vector6d& d) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = Eigen::Quaterniond(expSO3(d.head<3>()) * T.linear()).normalized().toRotationMatrix();
  out.translation() = T.translation() + d.tail<3>();
  return out;
}

Vector6d boxminus(const Eigen::Isometry3d& T, const Eigen::Isometry3d& T0) {
  Vector6d d;
  d << logSO3(T.linear() * T0.linear().transpose()), T.translation() - T0.translation();
  return d;
}

double squaredMahalanobis(const PoseWithCovariance& pose, const Eigen::Isometry3d& T) {
  const Vector6d d = boxminus(T, pose.T);
  return d.dot(pose.P.ldlt().solve(d));
}

double squaredMahalanobis(const PoseWithCovariance& a, const PoseWithCovariance& b) {
  return squaredMahalanobis(PoseWithCovariance{a.T, a.P + b.P}, b.T);
}

// To first order, with the left, decoupled perturbations of both factors: d phi = d phi_1 + R d phi_2,
// d t = d t_1 + R d t_2 - [R t_2]x d phi_1.
PoseWithCovariance operator*(const PoseWithCovariance& T_a_b, const PoseWithCovariance& T_b_c) {
  const Eigen::Matrix3d R = T_a_b.T.linear();
  Matrix6d F = Matrix6d::Identity();
  F.bottomLeftCorner<3, 3>() = -skew(R * T_b_c.T.translation());
  return {T_a_b.T * T_b_c.T, F * T_a_b.P * F.transpose() + rotateCovariance(R, T_b_c.P)};
}

// To first order: d phi' = -R^T d phi, d t' = -R^T (d t + [t]x d phi).
PoseWithCovariance inverse(const PoseWithCovariance& T_a_b) {
  Matrix6d F = Matrix6d::Identity();
  F.bottomLeftCorner<3, 3>() = skew(T_a_b.T.translation());
  return {T_a_b.T.inverse(), rotateCovariance(T_a_b.T.linear().transpose(), F * T_a_b.P * F.transpose())};
}

Matrix6d adjoint(const Eigen::Isometry3d& T_a_b) {
  Matrix6d Ad = Matrix6d::Zero();
  Ad.topLeftCorner<3, 3>() = Ad.bottomRightCorner<3, 3>() = T_a_b.linear();
  Ad.bottomLeftCorner<3, 3>() = skew(T_a_b.translation()) * T_a_b.linear();
  return Ad;
}

Matrix6d symmetricInverse(const Matrix6d& A) {
  const Matrix6d inverse = A.ldlt().solve(Matrix6d::Identity());
  return 0.5 * (inverse + inverse.transpose());
}

double largestStd(const Eigen::Matrix3d& covariance) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eig;
  eig.computeDirect(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eig.eigenvalues()[2]));
}

double largestRotationStd(const Matrix6d& P) { return largestStd(P.topLeftCorner<3, 3>()); }
double largestTranslationStd(const Matrix6d& P) { return largestStd(P.bottomRightCorner<3, 3>()); }

PrincipalStd principalStd(const Matrix6d& P) {
  PrincipalStd out;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eig;
  eig.computeDirect(P.topLeftCorner<3, 3>());
  out.rotation = eig.eigenvalues().cwiseMax(0).cwiseSqrt();
  out.rotation_axes = eig.eigenvectors();
  eig.computeDirect(P.bottomRightCorner<3, 3>());
  out.translation = eig.eigenvalues().cwiseMax(0).cwiseSqrt();
  out.translation_axes = eig.eigenvectors();
  return out;
}

std::string freeMotions(const PrincipalStd& known, double max_rotation, double max_translation,
                        const Eigen::Matrix3d& R) {
  std::string text;
  const auto add = [&](const char* motion, const Eigen::Vector3d& v) {
    text += (text.empty() ? "" : ", ") + std::string(motion) + directionText(R * v);
  };
  for (int i = 0; i < 3; ++i)
    if (!(known.rotation[i] <= max_rotation)) add("rotation about ", known.rotation_axes.col(i));
  for (int i = 0; i < 3; ++i)
    if (!(known.translation[i] <= max_translation)) add("translation along ", known.translation_axes.col(i));
  return text;
}

}  // namespace facetloc
