// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/dense_refinement.h>
#include <facetloc/registration/depth_consistency.h>
#include <facetloc/registration/depth_difference.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

constexpr double kFarthest = 1 / 8.0;  // smallest inverse depth used [1/m]
constexpr double kConverged = 1e-5;    // norm of a step [rad, m]

struct NormalEquations {
  Matrix6d A = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double weight = 0;  // sum of the robust weights
  bool of_noise = false;
  Matrix6d noise = Matrix6d::Zero();  // if wanted: what gradients of unit variance add to A by chance
};

void addPicture(const DepthPicture& scene, const PosedPicture& model, const Eigen::Isometry3d& T_w_c,
                const Matrix6d& uncertainty, double error, double gate, NormalEquations& n) {
  const DepthPicture& b = *model.picture;
  const Eigen::Isometry3d T_m_c = model.T_w_c.inverse() * T_w_c;
  const Eigen::Matrix3d R_m_c = T_m_c.linear(), R_w_m = model.T_w_c.linear();
  const Intrinsics& c = b.camera;
  const int step = gridStep(scene, kFineColumns);
  for (int v = step / 2; v < scene.camera.height; v += step)
    for (int u = step / 2; u < scene.camera.width; u += step) {
      const double rho =
          DepthPicture::kQuantum * scene.inverse_depth[static_cast<std::size_t>(v) * scene.camera.width + u];
      if (rho < kFarthest) continue;
      const Eigen::Vector3d ray = scene.camera.ray(u, v);
      DepthDifference d;
      if (!compareDepth(R_m_c * ray, T_m_c.translation(), rho, b, error, d)) continue;
      const Eigen::Vector3d a = R_w_m * d.by_point;
      const Eigen::Vector3d arm = T_w_c.linear() * ray / rho;
      Vector6d J;
      J << arm.cross(a), a;
      const double largest2 = gate * gate * (error * error + J.dot(uncertainty * J));
      if (d.residual * d.residual >= largest2) continue;
      const double robust = std::pow(1 - d.residual * d.residual / largest2, 2);  // Tukey's weight
      n.A.selfadjointView<Eigen::Lower>().rankUpdate(J, robust);
      n.g += robust * d.residual * J;
      n.weight += robust;
      if (!n.of_noise) continue;
      for (const Eigen::Vector3d& by_gradient :
           {Eigen::Vector3d(-c.fx, 0, c.fx * d.x), Eigen::Vector3d(0, -c.fy, c.fy * d.y)}) {
        const Eigen::Vector3d da = d.inverse_depth * R_w_m * by_gradient;
        J << arm.cross(da), da;
        n.noise.selfadjointView<Eigen::Lower>().rankUpdate(J, robust);
      }
    }
}

// Drops the directions in which the gradients tell hardly more than their own noise and the bands of a coarse
// quantisation would (after Zhang, Kaess, Singh, ICRA 2016), and takes the noise out of the others.
void dropFeigned(double inverse_depth_std, double significance, NormalEquations& n) {
  const double gradient_variance =
      inverse_depth_std * inverse_depth_std / (2 * DepthSlope::kReach * DepthSlope::kReach);
  constexpr double kRegular = 1e-9;  // of the trace
  Matrix6d N = gradient_variance * Matrix6d(n.noise.selfadjointView<Eigen::Lower>());
  N.diagonal().array() += kRegular * N.trace();
  const Matrix6d A = n.A.selfadjointView<Eigen::Lower>();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d> eig(A, N);
  // V^T N V = 1 and V^T A V = diag(lambda): lambda is 1 where there is nothing but noise.
  const Matrix6d NV = N * eig.eigenvectors();
  const Vector6d lambda = eig.eigenvalues();
  const Vector6d kept = (lambda.array() > significance).select(Vector6d::Ones(), Vector6d::Zero());
  n.g = NV * kept.cwiseProduct(eig.eigenvectors().transpose() * n.g);
  n.A = NV * kept.cwiseProduct((lambda.array() - 1).matrix()).asDiagonal() * NV.transpose();
}

}  // namespace

bool refineByDepth(const DepthPicture& scene, const std::vector<PosedPicture>& pictures,
                   double inverse_depth_std, const DenseRefinementParams& params, PoseWithCovariance& pose,
                   Matrix6d* information) {
  if (scene.empty()) return false;
  const Eigen::LLT<Matrix6d> prior_factor(pose.P);
  if (prior_factor.info() != Eigen::Success) return false;
  const Matrix6d prior_information = prior_factor.solve(Matrix6d::Identity());
  const double error = params.pixel_error * inverse_depth_std;
  const double of_pixel = 1 / (error * error * params.correlated_pixels);
  Eigen::Isometry3d T = pose.T;
  Matrix6d uncertainty = pose.P;
  const auto normalEquations = [&] {
    NormalEquations n;
    n.of_noise = params.significance > 0;
    for (const PosedPicture& picture : pictures)
      if (!picture.picture->empty()) addPicture(scene, picture, T, uncertainty, error, params.robust_gate, n);
    if (n.of_noise && n.weight > 0) dropFeigned(inverse_depth_std, params.significance, n);
    return n;
  };
  for (int i = 0; i < params.iterations; ++i) {
    const NormalEquations n = normalEquations();
    if (!(n.weight > 0)) return false;
    const Matrix6d A = of_pixel * Matrix6d(n.A.selfadjointView<Eigen::Lower>());
    const Eigen::LDLT<Matrix6d> solver(A + prior_information);
    if (solver.info() != Eigen::Success || !solver.isPositive()) return false;
    const Vector6d step = -solver.solve(of_pixel * n.g + prior_information * perturbation(pose.T, T));
    if (!step.allFinite()) return false;
    T = perturbed(T, step);
    if (i > 0 && step.norm() < kConverged) break;
    constexpr double kSmaller = 0.25;  // variance after a step, while distant pixels may still mislead it
    uncertainty *= kSmaller;
  }
  pose.T = T;
  if (information) *information = of_pixel * Matrix6d(normalEquations().A.selfadjointView<Eigen::Lower>());
  return true;
}

}  // namespace facetloc
