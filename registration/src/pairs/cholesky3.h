// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <cmath>

namespace facetloc::internal {

/** \brief Cholesky factor of a symmetric 3x3 matrix, written out: every gate and every update ends in one of
 * these, and the general-purpose solver spends most of its time on generality. */
class Cholesky3 {
public:
  /** \brief Factors S = L L^T from its lower triangle; false if S is not positive definite. */
  bool compute(const Eigen::Matrix3d& S) {
    const double d0 = S(0, 0);
    if (!(d0 > 0)) return false;
    l00_ = std::sqrt(d0);
    l10_ = S(1, 0) / l00_;
    l20_ = S(2, 0) / l00_;
    const double d1 = S(1, 1) - l10_ * l10_;
    if (!(d1 > 0)) return false;
    l11_ = std::sqrt(d1);
    l21_ = (S(2, 1) - l20_ * l10_) / l11_;
    const double d2 = S(2, 2) - l20_ * l20_ - l21_ * l21_;
    if (!(d2 > 0)) return false;
    l22_ = std::sqrt(d2);
    return true;
  }
  /** \brief L^-1 v. */
  Eigen::Vector3d whiten(const Eigen::Vector3d& v) const {
    const double a = v[0] / l00_, b = (v[1] - l10_ * a) / l11_;
    return {a, b, (v[2] - l20_ * a - l21_ * b) / l22_};
  }
  /** \brief S^-1 v. */
  Eigen::Vector3d solve(const Eigen::Vector3d& v) const {
    const Eigen::Vector3d w = whiten(v);
    const double c = w[2] / l22_, b = (w[1] - l21_ * c) / l11_;
    return {(w[0] - l10_ * b - l20_ * c) / l00_, b, c};
  }
  /** \brief S^-1 M, column by column. */
  template <int N>
  Eigen::Matrix<double, 3, N> solve(const Eigen::Matrix<double, 3, N>& M) const {
    Eigen::Matrix<double, 3, N> out;
    for (int i = 0; i < N; ++i) out.col(i) = solve(Eigen::Vector3d(M.col(i)));
    return out;
  }
  /** \brief v^T S^-1 v. */
  double squaredMahalanobis(const Eigen::Vector3d& v) const { return whiten(v).squaredNorm(); }
  double logDeterminant() const { return 2 * std::log(l00_ * l11_ * l22_); }

private:
  double l00_ = 1, l10_ = 0, l11_ = 1, l20_ = 0, l21_ = 0, l22_ = 1;
};

}  // namespace facetloc::internal
