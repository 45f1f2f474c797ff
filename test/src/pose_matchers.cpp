// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/testing/pose_matchers.h>

#include <Eigen/Eigenvalues>

namespace facetloc::test {

bool posesNear(const Eigen::Isometry3d& got, const Eigen::Isometry3d& expected, double metres, double degrees,
               Listener& listener) {
  const double distance = (got.translation() - expected.translation()).norm();
  const double angle = rotationAngle(got.linear() * expected.linear().transpose()) / kDegree;
  listener << "differs by " << distance << " m and " << angle << " deg";
  return distance <= metres && angle <= degrees;
}

bool matricesNear(const AnyMatrix& got, const AnyMatrix& expected, double tolerance, Listener& listener) {
  const Eigen::MatrixXd difference = got - expected;
  const double worst = difference.cwiseAbs().maxCoeff();
  listener << "differs by up to " << worst << ":\n" << difference;
  return worst <= tolerance;
}

bool positiveSemidefinite(const AnyMatrix& matrix, double tolerance, Listener& listener) {
  const double asymmetry = (matrix - matrix.transpose()).cwiseAbs().maxCoeff();
  const double smallest =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues()[0];
  listener << "asymmetry " << asymmetry << ", smallest eigenvalue " << smallest;
  return asymmetry <= tolerance && smallest >= -tolerance;
}

bool rotation(const Eigen::Matrix3d& matrix, Listener& listener) {
  const double error = (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).norm();
  listener << "R R^T - I has norm " << error << ", det R = " << matrix.determinant();
  return error < 1e-12 && matrix.determinant() > 0;
}

}  // namespace facetloc::test
