// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace facetloc::test {

/** \brief Jacobian of a vector function at x by central differences: error O(step^2) + O(1e-16 / step). */
template <int M, int N, class Function>
Eigen::Matrix<double, M, N> numericJacobian(const Function& f, const Eigen::Matrix<double, N, 1>& x,
                                            double step = 1e-6) {
  Eigen::Matrix<double, M, N> J;
  for (int i = 0; i < N; ++i) {
    const Eigen::Matrix<double, N, 1> d = step * Eigen::Matrix<double, N, 1>::Unit(i);
    const Eigen::Matrix<double, M, 1> forward = f(x + d), backward = f(x - d);
    J.col(i) = (forward - backward) / (2 * step);
  }
  return J;
}

}  // namespace facetloc::test
