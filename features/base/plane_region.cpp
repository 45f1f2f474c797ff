// SPDX-License-Identifier: BSD-3-Clause
#include "base/plane_region.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace facetloc {

using namespace internal;
namespace {

constexpr double kReferenceWidth = 320.0;
constexpr double kMinPlaneDistance =
    0.05;  // planes through the camera centre are seen edge-on [m] (METHOD 8)
// The paper's eq. (4) with its authors' sensor constants: 1 disparity unit, twice the noise, and 1 px at
// 320x240.
constexpr double kPaperDepthFactor = 2.0;
constexpr double kFaithfulPixelStd = 1.0;
constexpr double kCorrelatedPixels =
    100.0;  // pixels at 320x240 that share one independent error, N_eff of METHOD 7.3
// Smallest sqrt(lambda_2) of a segment: as it is, unless it is wide compared with the noise, and as if it
// faced the camera (METHOD 8).
constexpr double kMinWidth = 0.03;       // [m]
constexpr double kMinWidthPixels = 2.0;  // [px at the working size]
constexpr double kMinIncidence = 0.1;    // |cosine| between normal and ray at the centroid
constexpr double kMinIndependent = 8.0;
constexpr double kWideInNoise = 5.0;  // a strip this many sigma_r wide has a slope worth measuring

// sigma_r^2: how far a single point may lie off a plane, Eq. (4).
double offsetVariance(const Eigen::Vector3d& normal, const Eigen::Vector3d& centroid,
                      const Intrinsics& camera, const SensorNoise& noise) {
  const double pixel_std = kFaithfulPixelStd * camera.width / kReferenceWidth;
  const Eigen::Matrix3d Sigma_C =
      pointCovariance(centroid, camera, pixel_std, kPaperDepthFactor * noise.ofInverseDepth(centroid.z()));
  return normal.dot(Sigma_C * normal);
}

// [px of the image]
double correlationLength(const SensorNoise& noise, const Intrinsics& camera) {
  return noise.correlation_px * std::sqrt(scaledPixels(1, camera));
}

// White noise with which neighbouring pixels would differ as much as with smooth noise. Only this tilts a
// narrow strip: the rest of their noise its pixels share.
SensorNoise noiseOfNeighbours(const SensorNoise& noise, const Intrinsics& camera, double z) {
  SensorNoise white = noise;
  const double correlation = correlationLength(noise, camera);
  if (correlation > 1)
    static_cast<DepthNoise&>(white) = noise.scaledTo(noise.ofInverseDepth(z) / correlation, z);
  return white;
}

// Pixels that share one error, if noise is smooth: the integral of its correlation.
double correlatedPixels(const SensorNoise& noise, const Intrinsics& camera) {
  const double correlation = correlationLength(noise, camera);
  return 180 * kDegree * correlation * correlation;
}

// Uncertainty of the plane fit, METHOD 7.3.
Eigen::Matrix3d uncertaintyOfFit(const PlaneRegion& region, const Segment& s, double rho,
                                 const Intrinsics& camera, const SensorNoise& noise,
                                 const SegmentEstimationParams& params) {
  const double correlated =
      std::max(scaledPixels(kCorrelatedPixels, camera), correlatedPixels(noise, camera));
  const double independent = std::max(kMinIndependent, region.support / correlated);
  const double std = noise.ofInverseDepth(s.t.z()), variance = std * std;
  Eigen::Matrix3d Sigma_m = (region.support / independent) * variance * region.rays.inverse();  // METHOD 7.3
  Sigma_m.diagonal() +=
      Eigen::Array3d(noise.distortion_slope, noise.distortion_slope, noise.distortion_offset)
          .square()
          .matrix();
  Eigen::Matrix3d Sigma_q = slopeOffsetCovariance(s.R, s.t, rho, Sigma_m);
  Sigma_q += paperCovariance(s.normal(), s.t, s.lambda, camera, params.errors.edge_factor, noise);
  Sigma_q.diagonal() += Eigen::Array3d(params.errors.slope_floor_deg * kDegree,
                                       params.errors.slope_floor_deg * kDegree, params.errors.offset_floor)
                            .square()
                            .matrix();
  return Sigma_q;
}

}  // namespace

Eigen::Matrix3d paperCovariance(const Eigen::Vector3d& normal, const Eigen::Vector3d& centroid,
                                const Eigen::Vector2d& lambda, const Intrinsics& camera, double kappa_u,
                                const SensorNoise& noise) {
  const double var_r = kappa_u * kappa_u * offsetVariance(normal, centroid, camera, noise);  // Eq. (4)
  return Eigen::Vector3d(var_r / (lambda[0] + var_r), var_r / (lambda[1] + var_r), var_r)
      .asDiagonal();  // Eq. (5)
}

Eigen::Matrix3d slopeOffsetCovariance(const Eigen::Matrix3d& R, const Eigen::Vector3d& t, double rho,
                                      const Eigen::Matrix3d& Sigma_m) {
  Eigen::Matrix3d J_q;
  J_q << R.col(0).transpose(), R.col(1).transpose(), -t.transpose();
  J_q *= rho;
  return J_q * Sigma_m * J_q.transpose();
}

namespace internal {

bool describe(const PlaneRegion& region, const Intrinsics& camera, const SensorNoise& noise,
              const SegmentEstimationParams& params, Segment& s, const char*& why_not) {
  const double length = region.m.norm();
  why_not = "lies in a plane through the camera";
  if (!(length > 1e-6) || 1.0 / length < kMinPlaneDistance) return false;
  const Eigen::Vector3d n = region.m / length;
  const double rho = 1.0 / length;

  // Support points projected orthogonally onto the plane.
  const Eigen::Matrix3d in_plane = Eigen::Matrix3d::Identity() - n * n.transpose();
  const Eigen::Matrix3d C = in_plane * region.covariance * in_plane;
  s.t = region.mean - (n.dot(region.mean) - rho) * n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eig(C);
  Eigen::Vector3d x = eig.eigenvectors().col(2);
  x = (x - n * n.dot(x)).normalized();
  s.R << x, n.cross(x), n;
  s.lambda = {eig.eigenvalues()[2], std::max(0.0, eig.eigenvalues()[1])};
  s.num_points = static_cast<std::int32_t>(region.support);

  const double width = std::sqrt(s.lambda[1]);
  const double nearest =
      s.t.z() - std::max(std::sqrt(s.lambda[0]) * std::abs(s.R(2, 0)), width * std::abs(s.R(2, 1)));
  why_not = "is farther away than segments may be";
  if (nearest > params.max_depth) return false;
  why_not = "is seen edge-on";
  if (n.dot(s.t.normalized()) < kMinIncidence) return false;
  why_not = "is too narrow";
  // A strip fixes its slope across only if it is wide compared with the noise, or with the unevenness of
  // furniture.
  const double noise_width =
      kWideInNoise * std::sqrt(offsetVariance(n, s.t, camera, noiseOfNeighbours(noise, camera, s.t.z())));
  if (!(width >= std::min(kMinWidth, noise_width))) return false;
  if (!(width * camera.fx / s.t.z() >= kMinWidthPixels)) return false;

  why_not = "has no uncertainty that could be estimated";
  s.Sigma_q = params.paper_uncertainty ? paperCovariance(n, s.t, s.lambda, camera, 1, noise)
                                       : uncertaintyOfFit(region, s, rho, camera, noise, params);
  s.noise = noise.ofInverseDepth(DepthNoise::kUsualDepth);
  return s.Sigma_q.allFinite() && s.Sigma_q.llt().info() == Eigen::Success;
}

}  // namespace internal
}  // namespace facetloc
