// SPDX-License-Identifier: BSD-3-Clause
#include "depth/dense_refinement.h"

#include "depth/depth_consistency.h"
#include "depth/depth_difference.h"
#include "depth/depth_normal_equations.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace facetloc::internal {
namespace {

constexpr double kConverged = 1e-5;  // norm of a step [rad, m]

// Variance of the gradient of inverse depth that a picture's noise alone makes [1/m^2/px^2].
double gradientVariance(const DepthPicture& picture) {
  const double std = picture.noise.ofInverseDepth(DepthNoise::kUsualDepth);
  return std * std / (2 * DepthDifference::kReach * DepthDifference::kReach);
}

// Drops the directions in which the gradients tell hardly more than their own noise and the bands of a coarse
// quantisation would (after Zhang, Kaess, Singh, ICRA 2016), and takes the noise out of the others.
void dropFeigned(double significance, DepthNormalEquations& n) {
  constexpr double kRegular = 1e-9;  // share of the trace
  Matrix6d N = n.noise.selfadjointView<Eigen::Lower>();
  N.diagonal().array() += kRegular * N.trace();
  const Matrix6d A = n.A.selfadjointView<Eigen::Lower>();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d> eig(A, N);
  // V^T N V = 1 and V^T A V = diag(lambda): lambda is 1 where there is nothing but noise, or less.
  const Matrix6d NV = N * eig.eigenvectors();
  const Vector6d lambda = eig.eigenvalues();
  const Vector6d kept =
      (lambda.array() > std::max(1.0, significance)).select(Vector6d::Ones(), Vector6d::Zero());
  n.g = NV * kept.cwiseProduct(eig.eigenvectors().transpose() * n.g);
  n.A = NV * kept.cwiseProduct((lambda.array() - 1).matrix()).asDiagonal() * NV.transpose();
}

}  // namespace

bool refineByDepth(const DepthPicture& scene, const std::vector<PosedPicture>& pictures,
                   const DenseRefinementParams& params, PoseWithCovariance& pose, Matrix6d* information) {
  if (scene.empty()) return false;
  const Eigen::LLT<Matrix6d> prior_factor(pose.P);
  if (prior_factor.info() != Eigen::Success) return false;
  const Matrix6d prior_information = prior_factor.solve(Matrix6d::Identity());
  Eigen::Isometry3d T = pose.T;
  Matrix6d uncertainty = pose.P;
  const auto normalEquations = [&] {
    DepthNormalEquations n;
    for (const PosedPicture& p : pictures) {
      const double noise = commonNoise(scene, *p.picture).ofInverseDepth(DepthNoise::kUsualDepth);
      const double error = params.pixel_error * noise;
      DepthNormalEquations of_picture;
      of_picture.of_noise = params.significance > 0;
      of_picture.add(scene, gridStep(scene, kFineColumns), T, *p.picture, p.T_w_c, uncertainty, error,
                     params.robust_gate);
      n.add(of_picture, 1 / (error * error * params.correlated_pixels), gradientVariance(*p.picture));
    }
    if (params.significance > 0 && n.weight > 0) dropFeigned(params.significance, n);
    return n;
  };
  for (int i = 0; i < params.iterations; ++i) {
    const DepthNormalEquations n = normalEquations();
    if (!(n.weight > 0)) return false;
    const Matrix6d A = n.A.selfadjointView<Eigen::Lower>();
    const Eigen::LDLT<Matrix6d> solver(A + prior_information);
    if (solver.info() != Eigen::Success || !solver.isPositive()) return false;
    const Vector6d step = -solver.solve(n.g + prior_information * perturbation(pose.T, T));
    if (!step.allFinite()) return false;
    T = perturbed(T, step);
    if (i > 0 && step.norm() < kConverged) break;
    constexpr double kSmaller = 0.25;  // variance after a step, while distant pixels may still mislead it
    uncertainty *= kSmaller;
  }
  pose.T = T;
  if (information) *information = normalEquations().A.selfadjointView<Eigen::Lower>();
  return true;
}

}  // namespace facetloc::internal
