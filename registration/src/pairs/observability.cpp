// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/cholesky3.h"
#include "pairs/plane_measurement.h"

#include <facetloc/registration/observability.h>

#include <Eigen/Eigenvalues>

namespace facetloc {

using namespace internal;

Matrix6d informationOf(const std::vector<Segment>& segments) {
  Matrix6d information = Matrix6d::Zero();
  for (const Segment& s : segments) {
    PlaneMeasurement m;  // the view measured against itself
    Cholesky3 noise;
    if (measurePlane(s, s, Eigen::Isometry3d::Identity(), 0.0, m) && noise.compute(m.W))
      information += m.H.transpose() * noise.solve<6>(m.H);
  }
  return information;
}

PrincipalStd observability(const Matrix6d& information) {
  constexpr double kWeakRotation = 30 * kDegree, kWeakTranslation = 10;  // METHOD 6.3
  Matrix6d Lambda = information;
  Lambda.diagonal().head<3>().array() += 1 / (kWeakRotation * kWeakRotation);
  Lambda.diagonal().tail<3>().array() += 1 / (kWeakTranslation * kWeakTranslation);
  // Blocks of the inverse by Schur complements; eigenvalues of 3x3 matrices in closed form.
  const Eigen::Matrix3d A = Lambda.topLeftCorner<3, 3>(), B = Lambda.topRightCorner<3, 3>(),
                        C = Lambda.bottomRightCorner<3, 3>();
  PrincipalStd o;
  Cholesky3 of_A, of_C;
  if (!of_A.compute(A) || !of_C.compute(C)) return o;
  const Eigen::Matrix3d rotation = A - B * of_C.solve<3>(B.transpose());
  const Eigen::Matrix3d translation = C - B.transpose() * of_A.solve<3>(B);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eig;
  const auto stds = [&eig] {
    return Eigen::Vector3d(eig.eigenvalues().reverse().cwiseMax(1e-12).cwiseInverse().cwiseSqrt());
  };
  eig.computeDirect(rotation);
  o.rotation = stds();
  o.rotation_axes = eig.eigenvectors().rowwise().reverse();
  eig.computeDirect(translation);
  o.translation = stds();
  o.translation_axes = eig.eigenvectors().rowwise().reverse();
  return o;
}

}  // namespace facetloc
