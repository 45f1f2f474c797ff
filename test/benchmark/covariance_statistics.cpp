// SPDX-License-Identifier: BSD-3-Clause
#include "covariance_statistics.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace facetloc::benchmarks {

void CovarianceStatistics::add(const PoseWithCovariance& pose, const Eigen::Isometry3d& T_true,
                               const Matrix6d& truth) {
  const Vector6d e = boxminus(T_true, pose.T);
  const Matrix6d P = pose.P + truth;
  const Eigen::LLT<Matrix6d> root(P);
  if (!P.allFinite() || root.info() != Eigen::Success) {
    ++invalid_;
    return;
  }
  nees_.push_back(e.dot(root.solve(e)));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> position(P.bottomRightCorner<3, 3>());
  for (std::size_t axis = weakest; axis <= strongest; ++axis) {
    const auto column = static_cast<Eigen::Index>(strongest - axis);  // variances ascend
    ratios_[axis].push_back(std::abs(position.eigenvectors().col(column).dot(e.tail<3>())) /
                            std::sqrt(position.eigenvalues()[column]));
  }
}

double CovarianceStatistics::inside(double ellipsoid) const {
  if (nees_.empty()) return 0;
  const auto n = std::count_if(nees_.begin(), nees_.end(), [&](double x) { return x <= ellipsoid; });
  return static_cast<double>(n) / static_cast<double>(nees_.size());
}

Matrix6d covarianceOfTruth(double rotation_deg, double translation_mm) {
  constexpr double kAxes = 3;
  const double rotation = rotation_deg * kDegree, translation = 1e-3 * translation_mm;
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(rotation * rotation / kAxes),
      Eigen::Vector3d::Constant(translation * translation / kAxes);
  return variances.asDiagonal();
}

}  // namespace facetloc::benchmarks
