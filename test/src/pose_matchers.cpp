// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/testing/pose_matchers.h>

#include <Eigen/Eigenvalues>

namespace facetloc::test {

double smallestEigenvalue(const double* matrix, Eigen::Index size) {
  const Eigen::Map<const Eigen::MatrixXd> A(matrix, size, size);
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

}  // namespace facetloc::test
