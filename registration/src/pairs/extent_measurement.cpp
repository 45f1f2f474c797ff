// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/extent_measurement.h"

#include <Eigen/Cholesky>

namespace facetloc::internal {
namespace {

// A stretch of half length a has the variance a^2 / 3 about its middle. Two of them overlap as long as their
// middles are no more than 2 a apart, uniformly: a variance of 4 a^2 / 3, twice the sum of both.
constexpr double kOfOverlapping = 2;

}  // namespace

ExtentMeasurement measureExtent(const Segment& scene, const Segment& model, const Eigen::Isometry3d& T_m_c) {
  const Eigen::Vector3d moved = T_m_c.linear() * scene.t;
  const Eigen::Matrix<double, 3, 2> axes = model.R.leftCols<2>(),
                                    scene_axes = T_m_c.linear() * scene.R.leftCols<2>();
  ExtentMeasurement m;
  m.h = axes.transpose() * (moved + T_m_c.translation() - model.t);
  m.H << -axes.transpose() * skew(moved), axes.transpose();
  const Eigen::Matrix2d turned = axes.transpose() * scene_axes;
  m.W = kOfOverlapping * turned * scene.lambda.asDiagonal() * turned.transpose();
  m.W.diagonal() += kOfOverlapping * model.lambda;
  return m;
}

Matrix6d informationOf(const ExtentMeasurement& m) {
  const Eigen::LLT<Eigen::Matrix2d> W(m.W);
  if (W.info() != Eigen::Success) return Matrix6d::Zero();
  return m.H.transpose() * W.solve(m.H);
}

}  // namespace facetloc::internal
