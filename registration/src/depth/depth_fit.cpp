// SPDX-License-Identifier: BSD-3-Clause
#include "depth/depth_fit.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace facetloc::internal {
namespace {

constexpr int kFewestPixels = 60;                            // on the fine grid
constexpr std::array<double, 3> kSteps = {0.05, 0.15, 0.3};  // away from the minimum, some pixels [m]
constexpr double kTellingDrop = 2;      // significant drop of the log likelihood by a step [nats]
constexpr double kExactStd = 0.005;     // up to which derivatives are believed [m]
constexpr double kMetresPerRadian = 2;  // typical distance of the points that a rotation moves

// Least drop of the log likelihood by a step to either side [nats].
double drop(const DepthFit& fit, double here, const Eigen::Isometry3d& T, const Vector6d& step, int columns) {
  double least = std::numeric_limits<double>::infinity();
  for (const double sign : {-1, 1})
    if (const auto there = fit(boxplus(T, sign * step), columns)) least = std::min(least, here - *there);
  return std::isfinite(least) ? least : 0;
}

}  // namespace

DepthAgreement DepthFit::compare(const Scene& scene, const Eigen::Isometry3d& T_w_v, int columns) const {
  DepthAgreement sum;
  const Eigen::Isometry3d T_w_c = scene.T_v_c ? T_w_v * *scene.T_v_c : T_w_v;
  for (const PosedPicture& other : scene.others)
    sum += comparison_.compareBoth(*scene.picture, *other.picture, other.T_w_c.inverse() * T_w_c, columns);
  return sum;
}

DepthAgreement DepthFit::compare(const Eigen::Isometry3d& T_w_c, int columns) const {
  DepthAgreement sum;
  for (const Scene& scene : scenes_) sum += compare(scene, T_w_c, columns);
  return sum;
}

std::optional<double> logLikelihood(const DepthAgreement& seen, int columns) {
  if (seen.judged() * kFineColumns * kFineColumns < kFewestPixels * columns * columns) return {};
  return -kIndependentPixels * seen.misfit / seen.judged();
}

std::optional<double> DepthFit::operator()(const Eigen::Isometry3d& T_w_c, int columns) const {
  std::optional<double> sum;
  for (const Scene& scene : scenes_)
    if (const auto of_scene = logLikelihood(compare(scene, T_w_c, columns), columns))
      sum = sum.value_or(0) + *of_scene;
  return sum;
}

ShownInformation shownInformation(const Matrix6d& stated, const Eigen::Isometry3d& T_w_c, const DepthFit& fit,
                                  int columns) {
  const auto here = fit(T_w_c, columns);
  if (!here) return {stated, Matrix6d::Identity()};
  Vector6d scale;
  scale << Eigen::Vector3d::Constant(kMetresPerRadian), Eigen::Vector3d::Ones();
  const Vector6d unscale = scale.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eig(unscale.asDiagonal() * stated * unscale.asDiagonal());
  const Matrix6d& V = eig.eigenvectors();
  Vector6d along = eig.eigenvalues().cwiseMax(0), share = Vector6d::Ones();
  for (int k = 0; k < 6; ++k) {
    if (along[k] > 1 / (kExactStd * kExactStd)) continue;
    const Vector6d motion = unscale.cwiseProduct(V.col(k));
    double shown = 0;
    for (const double step : kSteps) {
      const double by_step = drop(fit, *here, T_w_c, step * motion, columns);
      if (by_step > kTellingDrop) shown = std::max(shown, 2 * by_step / (step * step));
    }
    if (along[k] > 0) share[k] = std::min(1.0, shown / along[k]);
    along[k] = along[k] > 0 ? share[k] * along[k] : shown;
  }
  return {scale.asDiagonal() * V * along.asDiagonal() * V.transpose() * scale.asDiagonal(),
          scale.asDiagonal() * V * share.asDiagonal() * V.transpose() * unscale.asDiagonal()};
}

PoseWithCovariance asShown(const PoseWithCovariance& found, const PoseWithCovariance& prior,
                           const DepthFit& fit, int columns) {
  const Matrix6d of_prior = symmetricInverse(prior.P);
  const ShownInformation shown =
      shownInformation(symmetricInverse(found.P) - of_prior, found.T, fit, columns);
  const Matrix6d P = symmetricInverse(of_prior + shown.information);
  const Vector6d pull = of_prior * boxminus(prior.T, found.T);
  return {boxplus(found.T, P * (pull - shown.share * pull)), P};
}

}  // namespace facetloc::internal
