// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment.h>

#include <Eigen/Geometry>

#include <cmath>

namespace facetloc::test {

/** \brief h(F, F', w, q, q') by eqs. (10)-(14) of the paper as they stand there. */
inline Eigen::Vector3d residualOfThePaper(const Segment& F, const Segment& Fp, const Eigen::Isometry3d& w,
                                          const Eigen::Vector3d& q, const Eigen::Vector3d& qp) {
  const auto normalOf = [](const Eigen::Vector3d& d) {
    return Eigen::Vector3d(Eigen::Vector3d(d[0], d[1], 1) /
                           std::sqrt(d[0] * d[0] + d[1] * d[1] + 1));  // Eq. (2)
  };
  const Eigen::Matrix3d R = w.linear();
  const Eigen::Vector3d n_F = normalOf(q), n_Fp = Fp.R.transpose() * R * F.R * n_F;  // Eq. (10)
  const double rho =
      q[2] + n_F.dot(F.R.transpose() * (F.t + R.transpose() * (w.translation() - Fp.t)));  // Eq. (11)
  const Eigen::Vector3d model = normalOf(qp);
  return {n_Fp.x() - model.x(), n_Fp.y() - model.y(), rho - qp[2]};
}

}  // namespace facetloc::test
