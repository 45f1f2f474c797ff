// SPDX-License-Identifier: BSD-3-Clause
#include "depth/dense_refinement.h"

#include "base/lanes.h"
#include "depth/depth_consistency.h"
#include "depth/depth_difference.h"
#include "depth/moved_pixels.h"

#include <facetloc/features/depth_picture.h>
#include <facetloc/features/pose.h>

#include <Eigen/Eigenvalues>

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr double kConverged = 1e-5;  // norm of a step [rad, m]
constexpr float kQuantum = static_cast<float>(DepthPicture::kQuantum);
constexpr auto kFarthest = static_cast<float>(DepthDifference::kFarthest);
constexpr int kSums = 21;  // entries of a lower triangle

/** Inputs of compareDepth, and its outputs. */
struct Comparison {
  TurnedRays in_model, in_world;
  float t[3], to_world[3][3], uncertainty[6][6];
  float fx, fy, cx, cy, error, gate;
  std::int32_t width, height;
  const std::uint16_t* picture;
  bool of_noise;
};

/** Sums, lane by lane. */
struct Sums {
  Floats A[kSums]{}, noise[kSums]{}, g[6]{}, weight{};
};

FACETLOC_ALWAYS_INLINE void turn(const float (&R)[3][3], const Floats (&b)[3], Floats (&a)[3]) {
  for (int i = 0; i < 3; ++i) a[i] = R[i][0] * b[0] + R[i][1] * b[1] + R[i][2] * b[2];
}

FACETLOC_ALWAYS_INLINE void addSquare(const Floats (&J)[6], const Floats& weight, Floats (&sums)[kSums]) {
  for (int i = 0, k = 0; i < 6; ++i) {
    const Floats wJ = weight * J[i];
    for (int j = 0; j <= i; ++j, ++k) sums[k] += wJ * J[j];
  }
}

// A point moves by a perturbation (rotation, translation) as its arm from the camera says.
FACETLOC_ALWAYS_INLINE void byPose(const Floats (&arm)[3], const Floats (&a)[3], Floats (&J)[6]) {
  J[0] = arm[1] * a[2] - arm[2] * a[1], J[1] = arm[2] * a[0] - arm[0] * a[2],
  J[2] = arm[0] * a[1] - arm[1] * a[0];
  J[3] = a[0], J[4] = a[1], J[5] = a[2];
}

// compareDepth for n pixels first, first + step, ... of a row v, and their sums.
FACETLOC_MULTIVERSION void addRow(const Comparison& c, const std::uint16_t* row, int v, int first, int step,
                                  int n, Sums& sums) {
  constexpr auto kNearest = static_cast<float>(DepthDifference::kNearest);
  constexpr int kReach = DepthDifference::kReach;
  float in_model[3], in_world[3];
  c.in_model.startRow(v, in_model), c.in_world.startRow(v, in_world);
  for (int i = 0; i < n; i += kLanes) {
    Floats u, rho, p[3], arm[3];
    readPixels(row, first, step, n, i, u, rho);
    c.in_model.along(in_model, u, p), c.in_world.along(in_world, u, arm);
    for (int k = 0; k < 3; ++k) p[k] += c.t[k] * rho, arm[k] /= rho;
    const Floats inverse = 1 / p[2];
    DepthDifferenceOf<Floats, Floats[3]> d;
    d.inverse_depth = rho * inverse, d.x = p[0] * inverse, d.y = p[1] * inverse;
    const Floats column = c.fx * d.x + c.cx, line = c.fy * d.y + c.cy;
    Ints used = (kLane < n - i) & (rho >= kFarthest) & (p[2] > kNearest * rho), uc, vc;
    findPixels(column + 0.5f, line + 0.5f, c.width, c.height, kReach, used, uc, vc);
    const Ints at = used ? vc * c.width + uc : Ints{} + (kReach * c.width + kReach);
    Ints five[5];
    for (int k = 0; k < kLanes; ++k) {
      const std::uint16_t* centre = c.picture + at[k];
      five[0][k] = centre[0], five[1][k] = centre[-kReach], five[2][k] = centre[kReach];
      five[3][k] = centre[-kReach * c.width], five[4][k] = centre[kReach * c.width];
    }
    Floats depth[5];
    for (int k = 0; k < 5; ++k) {
      used &= five[k] != 0;
      depth[k] = kQuantum * __builtin_convertvector(five[k], Floats);
    }
    d.dropBent(depth, c.error, used);
    d.setResidual(depth, column - __builtin_convertvector(uc, Floats),
                  line - __builtin_convertvector(vc, Floats), c.fx, c.fy);

    Floats a[3], J[6];
    turn(c.to_world, d.by_point, a);
    byPose(arm, a, J);
    Floats spread{};  // variance of the residual by the pose
    for (int k = 0; k < 6; ++k) {
      Floats row_sum{};
      for (int j = 0; j < 6; ++j) row_sum += c.uncertainty[k][j] * J[j];
      spread += J[k] * row_sum;
    }
    const Floats largest2 = c.gate * c.gate * (c.error * c.error + spread), squared = d.residual * d.residual;
    used &= squared < largest2;
    const Floats rest = 1 - squared / largest2, none{};
    const Floats robust = used ? rest * rest : none;  // Tukey's weight
    for (Floats& j : J) j = used ? j : none;
    addSquare(J, robust, sums.A);
    const Floats weighed = used ? robust * d.residual : none;
    for (int k = 0; k < 6; ++k) sums.g[k] += weighed * J[k];
    sums.weight += robust;
    if (!c.of_noise) continue;
    const Floats by_gradient[2][3] = {{-c.fx * d.inverse_depth, none, c.fx * d.x * d.inverse_depth},
                                      {none, -c.fy * d.inverse_depth, c.fy * d.y * d.inverse_depth}};
    for (const auto& b : by_gradient) {
      turn(c.to_world, b, a);
      byPose(arm, a, J);
      for (Floats& j : J) j = used ? j : none;
      addSquare(J, robust, sums.noise);
    }
  }
}

double totalOf(const Floats& x) {
  double sum = 0;
  for (int k = 0; k < kLanes; ++k) sum += x[k];
  return sum;
}

void addLower(const Floats (&sums)[kSums], Matrix6d& to) {
  for (int i = 0, k = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j, ++k) to(i, j) += totalOf(sums[k]);
}

/** Normal equations of a pose T_w_c by all pixels of its depth picture against other pictures:
 * residuals of inverse depth, weighed robustly, by its left perturbation. */
struct DepthNormalEquations {
  Matrix6d A = Matrix6d::Zero();  // lower triangle
  Vector6d g = Vector6d::Zero();
  double weight = 0;                  // sum of the robust weights
  bool of_noise = false;              // whether noise is wanted
  Matrix6d noise = Matrix6d::Zero();  // expected contribution to A of noise with unit variance of the
                                      // gradients; lower triangle

  /** Adds the measurements of a picture taken at T_w_m.
   * \param step distance of the scene's pixels that are compared
   * \param uncertainty covariance of T_w_c, by which residuals may be larger than by the error alone
   * \param error standard deviation of a difference of inverse depths [1/m]
   * \param gate residuals beyond this number of standard deviations have little weight */
  void add(const DepthPicture& scene, int step, const Eigen::Isometry3d& T_w_c, const DepthPicture& picture,
           const Eigen::Isometry3d& T_w_m, const Matrix6d& uncertainty, double error, double gate) {
    const Intrinsics &from = scene.camera, &to = picture.camera;
    constexpr int kLeast = 2 * DepthDifference::kReach + 1;  // pixels that a gradient takes
    if (scene.empty() || picture.empty() || to.width < kLeast || to.height < kLeast) return;
    const Eigen::Isometry3d T_m_c = T_w_m.inverse() * T_w_c;
    Comparison c;
    c.in_model = raysOf(from, T_m_c.linear()), c.in_world = raysOf(from, T_w_c.linear());
    for (int i = 0; i < 3; ++i) {
      c.t[i] = static_cast<float>(T_m_c.translation()[i]);
      for (int j = 0; j < 3; ++j) c.to_world[i][j] = static_cast<float>(T_w_m.linear()(i, j));
    }
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) c.uncertainty[i][j] = static_cast<float>(uncertainty(i, j));
    c.fx = static_cast<float>(to.fx), c.fy = static_cast<float>(to.fy);
    c.cx = static_cast<float>(to.cx), c.cy = static_cast<float>(to.cy);
    c.error = static_cast<float>(error), c.gate = static_cast<float>(gate);
    c.width = to.width, c.height = to.height, c.picture = picture.inverse_depth.data(), c.of_noise = of_noise;

    const int first = step / 2, n = gridPoints(from.width, step);
    Sums sums;
    for (int v = first; v < from.height; v += step)
      addRow(c, scene.inverse_depth.data() + static_cast<std::size_t>(v) * from.width, v, first, step, n,
             sums);
    addLower(sums.A, A);
    if (of_noise) addLower(sums.noise, noise);
    for (int k = 0; k < 6; ++k) g[k] += totalOf(sums.g[k]);
    weight += totalOf(sums.weight);
  }
  /** Adds those of one picture. \param of_pixel information of one pixel, by which they are weighed
   * \param gradient_variance of that picture, by which its part of the noise is weighed, too */
  void add(const DepthNormalEquations& of_picture, double of_pixel, double gradient_variance) {
    A += of_pixel * of_picture.A;
    g += of_pixel * of_picture.g;
    noise += of_pixel * gradient_variance * of_picture.noise;
    weight += of_picture.weight;
  }
};

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
    const Vector6d step = -solver.solve(n.g + prior_information * boxminus(T, pose.T));
    if (!step.allFinite()) return false;
    T = boxplus(T, step);
    if (i > 0 && step.norm() < kConverged) break;
    constexpr double kSmaller = 0.25;  // variance after a step, while distant pixels may still mislead it
    uncertainty *= kSmaller;
  }
  pose.T = T;
  if (information) *information = normalEquations().A.selfadjointView<Eigen::Lower>();
  return true;
}

}  // namespace facetloc::internal
