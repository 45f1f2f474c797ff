// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>

#include <array>
#include <cstdint>

namespace facetloc {

/** \brief Convex polygon in the plane of a segment, counter-clockwise about +z of S_F [m]. */
struct ConvexHull {
  static constexpr float kLargest = 1e3f;  ///< coordinate of a vertex [m]
  static constexpr int kMaxVertices = 24;
  std::array<Eigen::Vector2f, kMaxVertices> vertex;
  int size = 0;

  const Eigen::Vector2f* begin() const { return vertex.data(); }
  const Eigen::Vector2f* end() const { return vertex.data() + size; }
  /** \brief True if the point lies inside, or beyond no edge by more than the margin [m]. False for an empty
   * hull. */
  bool contains(const Eigen::Vector2f& p, float margin = 0.f) const;
  float area() const;  ///< [m^2]
};

/** \brief A planar surface segment F = (R_F, t_F, Sigma_q, Sigma_p) of the paper, eq. (6), in double
 * precision.
 *
 * The z axis of S_F is the plane's normal and points away from the camera (n . t_F > 0), x and y are the
 * principal axes of the supporting points. q = (s_x, s_y, r): tilt about the axes and offset of the true
 * plane, eqs. (2)-(3). */
struct Segment {
  Eigen::Matrix3d R =
      Eigen::Matrix3d::Identity();              ///< R_F: columns x, y, normal, in the camera or model frame
  Eigen::Vector3d t = Eigen::Vector3d::Zero();  ///< t_F: centroid of the supporting points [m]
  Eigen::Matrix3d Sigma_q = Eigen::Matrix3d::Zero();  ///< covariance of q [1, 1, m^2]
  Eigen::Vector2d lambda = Eigen::Vector2d::Zero();   ///< Sigma_p = diag(lambda), lambda_1 >= lambda_2 [m^2]
  std::int32_t num_points = 0;                        ///< support [px at the working size]
  ConvexHull hull;                                    ///< hull of the supporting points, in S_F
  double noise =
      0;  ///< noise of inverse depth at the usual depth, in the image that showed it; 0 = unknown [1/m]

  auto normal() const { return R.col(2); }
  double offset() const { return R.col(2).dot(t); }  ///< rho: distance of the plane from the origin [m]
  double area() const { return hull.area(); }        ///< [m^2]
};

/** \brief The segment expressed in another frame: every part of F moves with it. */
Segment transformed(const Segment& segment, const Eigen::Isometry3d& T);

}  // namespace facetloc
