// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment.h>

#include <Eigen/Cholesky>

#include <random>
#include <vector>

/** \file
 * Random poses, planes and disturbances for property tests; a seed gives the same numbers on every run. */
namespace facetloc::test {

using Rng = std::mt19937;

inline double uniform(Rng& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

/** \brief A vector of independent N(0, 1). */
template <int N>
Eigen::Matrix<double, N, 1> gaussian(Rng& rng) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, N, 1> v;
  for (int i = 0; i < N; ++i) v[i] = normal(rng);
  return v;
}

/** \brief A draw of N(0, Sigma). */
template <int N>
Eigen::Matrix<double, N, 1> gaussian(Rng& rng, const Eigen::Matrix<double, N, N>& Sigma) {
  return Sigma.llt().matrixL() * gaussian<N>(rng);
}

inline Eigen::Vector3d randomDirection(Rng& rng) { return gaussian<3>(rng).normalized(); }

/** \brief Any rotation, uniformly in angle about a random axis. */
inline Eigen::Matrix3d randomRotation(Rng& rng, double max_angle = 3.14) {
  const double angle = uniform(rng, 0, max_angle);
  return expSO3(angle * randomDirection(rng));
}

inline Eigen::Isometry3d randomPose(Rng& rng, double max_angle, double max_distance) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = randomRotation(rng, max_angle);
  const double distance = uniform(rng, 0, max_distance);
  T.translation() = distance * randomDirection(rng);
  return T;
}

/** \brief A random covariance with the given standard deviations and moderate correlations. */
template <int N>
Eigen::Matrix<double, N, N> randomCovariance(Rng& rng, const Eigen::Matrix<double, N, 1>& std) {
  Eigen::Matrix<double, N, N> A;
  for (int i = 0; i < N; ++i) A.col(i) = gaussian<N>(rng);
  const Eigen::Matrix<double, N, N> C = A * A.transpose() / N + 0.5 * Eigen::Matrix<double, N, N>::Identity();
  const Eigen::Matrix<double, N, 1> scale = std.cwiseQuotient(C.diagonal().cwiseSqrt());
  return scale.asDiagonal() * C * scale.asDiagonal();
}

inline ConvexHull rectangleHull(double half_x, double half_y) {
  const auto x = static_cast<float>(half_x), y = static_cast<float>(half_y);
  ConvexHull hull;
  for (const Eigen::Vector2f& v : {Eigen::Vector2f(-x, -y), {x, -y}, {x, y}, {-x, y}})
    hull.vertex[hull.size++] = v;
  return hull;
}

/** \brief A rectangular segment with consistent shape, outline and a plain diagonal uncertainty.
 *
 * The longer side runs along x of S_F, turned by the given angle about the normal. */
inline Segment rectangle(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double half_x,
                         double half_y, double turn = 0, double slope_std = 0.01, double offset_std = 0.01) {
  Segment s;
  const Eigen::Vector3d n = normal.normalized();
  const Eigen::Vector3d x = expSO3(turn * n) * n.unitOrthogonal();
  s.R << x, n.cross(x), n;
  s.t = centre;
  s.lambda = {half_x * half_x / 3, half_y * half_y / 3};
  s.Sigma_q.diagonal() << slope_std * slope_std, slope_std * slope_std, offset_std * offset_std;
  s.num_points = static_cast<std::int32_t>(1e4 * half_x * half_y) + 100;
  s.hull = rectangleHull(half_x, half_y);
  return s;
}

/** \brief A plausible segment: 1 to 5 m in front of the camera, 0.2 to 2 m large, not edge-on, with a full
 * Sigma_q. */
inline Segment randomSegment(Rng& rng) {
  const Eigen::Vector3d ray{uniform(rng, -0.5, 0.5), uniform(rng, -0.4, 0.4), 1};
  const Eigen::Vector3d centre = uniform(rng, 1, 5) * ray;
  Eigen::Vector3d n = randomDirection(rng);
  while (std::abs(n.dot(centre.normalized())) < 0.2) n = randomDirection(rng);
  if (n.dot(centre) < 0) n = -n;
  const double half_x = uniform(rng, 0.2, 2.0), half_y = half_x * uniform(rng, 0.2, 1.0);
  Segment s = rectangle(centre, n, half_x, half_y, uniform(rng, -3, 3));
  s.Sigma_q = randomCovariance<3>(rng, {0.01, 0.015, 0.01});
  return s;
}

/** \brief Where the true plane of a segment is measured with the error q: the true plane has the disturbance
 * q in the returned segment's frame (paper, eqs. (2)-(3)). */
inline Segment disturbed(const Segment& truth, const Eigen::Vector3d& q) {
  Segment s = truth;
  const Eigen::Vector3d tilted = Eigen::Vector3d(q[0], q[1], 1).normalized();
  const Eigen::Vector3d axis = tilted.cross(Eigen::Vector3d::UnitZ());
  const double angle = std::atan2(axis.norm(), tilted.z());
  if (angle > 0) s.R = truth.R * expSO3(angle * axis.normalized());  // s.R * tilted = truth.normal()
  s.t = truth.t - q[2] * truth.normal();
  return s;
}

/** \brief Another part of the same plane: the segment moved within its plane and turned about its normal. */
inline Segment movedInPlane(const Segment& s, double x, double y, double turn) {
  Segment out = s;
  out.t += x * s.R.col(0) + y * s.R.col(1);
  out.R = s.R * expSO3({0, 0, turn});
  Eigen::Matrix3d to_turned = expSO3({0, 0, -turn});  // slopes turn with the axes, the offset stays
  out.Sigma_q = to_turned * s.Sigma_q * to_turned.transpose();
  return out;
}

/** \brief A random other part of the same plane, up to so far away [m], its axes turned anyhow. */
inline Segment anotherPart(Rng& rng, const Segment& s, double max_x, double max_y) {
  const double x = uniform(rng, -max_x, max_x), y = uniform(rng, -max_y, max_y);
  return movedInPlane(s, x, y, uniform(rng, -3, 3));
}
inline Segment anotherPart(Rng& rng, const Segment& s, double max_shift) {
  return anotherPart(rng, s, max_shift, max_shift);
}

/** \brief A point of a cube about the origin. */
inline Eigen::Vector3d uniformVector(Rng& rng, double half_side) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = uniform(rng, -half_side, half_side);
  return v;
}

}  // namespace facetloc::test
