// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/testing/random_segments.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace facetloc::test {

double uniform(Rng& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

template <int N>
Eigen::Matrix<double, N, 1> gaussian(Rng& rng) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, N, 1> v;
  for (int i = 0; i < N; ++i) v[i] = normal(rng);
  return v;
}

template Eigen::Matrix<double, 1, 1> gaussian<1>(Rng&);
template Eigen::Vector2d gaussian<2>(Rng&);
template Eigen::Vector3d gaussian<3>(Rng&);
template Vector6d gaussian<6>(Rng&);

template <int N>
Eigen::Matrix<double, N, 1> gaussian(Rng& rng, const Eigen::Matrix<double, N, N>& Sigma) {
  return Sigma.llt().matrixL() * gaussian<N>(rng);
}

template Eigen::Vector3d gaussian<3>(Rng&, const Eigen::Matrix3d&);
template Vector6d gaussian<6>(Rng&, const Matrix6d&);

Eigen::Vector3d randomDirection(Rng& rng) { return gaussian<3>(rng).normalized(); }

Eigen::Matrix3d randomRotation(Rng& rng, double max_angle) {
  const double angle = uniform(rng, 0, max_angle);
  return expSO3(angle * randomDirection(rng));
}

Eigen::Isometry3d randomPose(Rng& rng, double max_angle, double max_distance) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = randomRotation(rng, max_angle);
  const double distance = uniform(rng, 0, max_distance);
  T.translation() = distance * randomDirection(rng);
  return T;
}

template <int N>
Eigen::Matrix<double, N, N> randomCovariance(Rng& rng, const Eigen::Matrix<double, N, 1>& std) {
  Eigen::Matrix<double, N, N> A;
  for (int i = 0; i < N; ++i) A.col(i) = gaussian<N>(rng);
  const Eigen::Matrix<double, N, N> C = A * A.transpose() / N + 0.5 * Eigen::Matrix<double, N, N>::Identity();
  const Eigen::Matrix<double, N, 1> scale = std.cwiseQuotient(C.diagonal().cwiseSqrt());
  return scale.asDiagonal() * C * scale.asDiagonal();
}

template Eigen::Matrix3d randomCovariance<3>(Rng&, const Eigen::Vector3d&);
template Matrix6d randomCovariance<6>(Rng&, const Vector6d&);

ConvexHull rectangleHull(double half_x, double half_y) {
  const auto x = static_cast<float>(half_x), y = static_cast<float>(half_y);
  ConvexHull hull;
  for (const Eigen::Vector2f& v : {Eigen::Vector2f(-x, -y), {x, -y}, {x, y}, {-x, y}})
    hull.vertex[hull.size++] = v;
  return hull;
}

Segment rectangle(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double half_x, double half_y,
                  double turn, double slope_std, double offset_std) {
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

Segment randomSegment(Rng& rng) {
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

Segment disturbed(const Segment& truth, const Eigen::Vector3d& q) {
  Segment s = truth;
  const Eigen::Vector3d tilted = Eigen::Vector3d(q[0], q[1], 1).normalized();
  const Eigen::Vector3d axis = tilted.cross(Eigen::Vector3d::UnitZ());
  const double angle = std::atan2(axis.norm(), tilted.z());
  if (angle > 0) s.R = truth.R * expSO3(angle * axis.normalized());  // s.R * tilted = truth.normal()
  s.t = truth.t - q[2] * truth.normal();
  return s;
}

Segment movedInPlane(const Segment& s, double x, double y, double turn) {
  Segment out = s;
  out.t += x * s.R.col(0) + y * s.R.col(1);
  out.R = s.R * expSO3({0, 0, turn});
  Eigen::Matrix3d to_turned = expSO3({0, 0, -turn});  // slopes turn with the axes, the offset stays
  out.Sigma_q = to_turned * s.Sigma_q * to_turned.transpose();
  return out;
}

Segment anotherPart(Rng& rng, const Segment& s, double max_x, double max_y) {
  const double x = uniform(rng, -max_x, max_x), y = uniform(rng, -max_y, max_y);
  return movedInPlane(s, x, y, uniform(rng, -3, 3));
}
Segment anotherPart(Rng& rng, const Segment& s, double max_shift) {
  return anotherPart(rng, s, max_shift, max_shift);
}

bool sameNumbers(const Segment& a, const Segment& b) {
  return a.R == b.R && a.t == b.t && a.Sigma_q == b.Sigma_q && a.lambda == b.lambda &&
         a.num_points == b.num_points &&
         std::equal(a.hull.begin(), a.hull.end(), b.hull.begin(), b.hull.end());
}

Eigen::Vector3d uniformVector(Rng& rng, double half_side) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = uniform(rng, -half_side, half_side);
  return v;
}

}  // namespace facetloc::test
