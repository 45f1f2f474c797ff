// SPDX-License-Identifier: BSD-3-Clause
#include "poses/pose_fusion.h"

#include <Eigen/Cholesky>

namespace facetloc::internal {

PoseWithCovariance fused(const PoseWithCovariance& a, const PoseWithCovariance& b) {
  const Matrix6d gain = a.P * symmetricInverse(a.P + b.P);
  const Matrix6d P = a.P - gain * a.P;
  return {boxplus(a.T, gain * boxminus(b.T, a.T)), 0.5 * (P + P.transpose())};
}

PoseWithCovariance covarianceIntersection(const PoseWithCovariance& a, const PoseWithCovariance& b) {
  constexpr int kSteps = 16;
  const Matrix6d of_a = symmetricInverse(a.P), of_b = symmetricInverse(b.P);
  double share = 1, most = 0;  // share of a; determinant of the information
  for (int i = kSteps; i >= 0; --i) {
    const double w = static_cast<double>(i) / kSteps;
    const double information = (w * of_a + (1 - w) * of_b).determinant();
    if (information > most) most = information, share = w;
  }
  const Matrix6d P = symmetricInverse(share * of_a + (1 - share) * of_b);
  return {boxplus(a.T, (1 - share) * P * of_b * boxminus(b.T, a.T)), P};
}

Matrix6d temper(const Matrix6d& prior, const Matrix6d& posterior, double part) {
  const Matrix6d before = prior.ldlt().solve(Matrix6d::Identity());
  const Matrix6d after = posterior.ldlt().solve(Matrix6d::Identity());
  return symmetricInverse(before + part * (after - before));
}

Matrix6d withSharedErrors(Matrix6d P, double rotation_std, double translation_std) {
  P.diagonal().head<3>().array() += rotation_std * rotation_std;
  P.diagonal().tail<3>().array() += translation_std * translation_std;
  return P;
}

}  // namespace facetloc::internal
