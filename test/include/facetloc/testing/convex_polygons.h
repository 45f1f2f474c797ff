// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>
#include <facetloc/features/segment.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

/** \file
 * The exact overlap criterion, the oracle for the one by ellipses (registration/METHOD 4.2). */
namespace facetloc::test {

using Polygon = std::vector<Eigen::Vector2d>;

inline double cross2(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/** \brief Convex hull, counter-clockwise. */
inline Polygon convexHull(Polygon points) {
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  Polygon hull;
  const auto chain = [&hull](auto begin, auto end) {
    const std::size_t base = hull.size();
    for (auto it = begin; it != end; ++it) {
      while (hull.size() >= base + 2 &&
             cross2(hull.back() - hull[hull.size() - 2], *it - hull[hull.size() - 2]) <= 0)
        hull.pop_back();
      hull.push_back(*it);
    }
    hull.pop_back();
  };
  chain(points.begin(), points.end());
  chain(points.rbegin(), points.rend());
  return hull;
}

/** \brief The outline of a segment moved by T, in the axes and about the origin of another one; shrunk
 * towards its centroid. */
inline Polygon outlineIn(const Segment& frame, const Segment& s, const Eigen::Isometry3d& T, double shrink) {
  Polygon out;
  for (const Eigen::Vector2f& v : s.hull) {
    const Eigen::Vector3d p = T * (s.t + shrink * (s.R.leftCols<2>() * v.cast<double>()));
    out.push_back((frame.R.transpose() * (p - frame.t)).head<2>());
  }
  return out;
}

/** \brief All displacements x for which A + x meets B: the set B + (-A). */
inline Polygon minkowskiDifference(const Polygon& b, const Polygon& a) {
  Polygon all;
  for (const Eigen::Vector2d& p : b)
    for (const Eigen::Vector2d& q : a) all.push_back(p - q);
  return convexHull(all);
}

/** \brief Distance of the origin from a convex polygon; 0 inside. */
inline double distanceFromOrigin(const Polygon& p) {
  bool inside = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Eigen::Vector2d &a = p[i], edge = p[(i + 1) % p.size()] - a;
    inside = inside && cross2(edge, -a) >= 0;
    const double along = std::clamp(-a.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (a + along * edge).norm());
  }
  return inside ? 0 : nearest;
}

/** \brief True if the outlines of both segments, shrunk by a factor, meet at this pose. */
inline bool outlinesMeet(const Segment& scene, const Segment& model, const Eigen::Isometry3d& T_m_c,
                         double shrink) {
  return distanceFromOrigin(
             minkowskiDifference(outlineIn(model, model, Eigen::Isometry3d::Identity(), shrink),
                                 outlineIn(model, scene, T_m_c, shrink))) == 0;
}

/** \brief Squared overlap distance, exact: from the origin to the set of displacements that make both
 * outlines meet, in units of the in-plane uncertainty; accepted up to 9.21. */
inline double exactOverlapDistance(const Segment& scene, const Segment& model,
                                   const PoseWithCovariance& T_m_c, double shrink = 0.8) {
  Eigen::Matrix<double, 3, 6> C;
  C << -skew(T_m_c.T.linear() * scene.t), Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, 3, 2> axes = model.R.leftCols<2>();
  const Eigen::Matrix2d Sigma = axes.transpose() * C * T_m_c.P * C.transpose() * axes +
                                std::pow(0.005, 2) * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d whiten = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(Sigma).operatorInverseSqrt();
  Polygon set = minkowskiDifference(outlineIn(model, model, Eigen::Isometry3d::Identity(), shrink),
                                    outlineIn(model, scene, T_m_c.T, shrink));
  for (Eigen::Vector2d& p : set) p = whiten * p;
  return std::pow(distanceFromOrigin(convexHull(set)), 2);
}

}  // namespace facetloc::test
