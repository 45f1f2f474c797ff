// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>
#include <facetloc/features/segment.h>

#include <limits>

namespace facetloc::internal {

using Matrix36d = Eigen::Matrix<double, 3, 6>;

/** \file
 * The measurement equation of the paper, h(F, F', w, q, q') = 0 (15): a scene segment F and a model segment
 * F' are one plane. w = T_m_c is the pose of the scene camera in the model, with the left, decoupled
 * perturbation of pose.h.
 *
 * With u the scene's normal in model axes and delta = R t_F + t - t' between the centroids (METHOD 3.2):
 * h = (x'.u - n'_1, y'.u - n'_2, r + m.t_F - u.(t' - t) - r'): two tilts and the distance of the model's
 * centroid from the scene's plane. (h_1, h_2) = 0 also for opposite normals: always test u.z' > 0 as well. */

/** \brief The measurement at q = q' = 0, its Jacobian H by (d phi, d t) and its noise W = E Sigma_q E^T +
 * E' Sigma_q' E'^T, with the Jacobians E by q and E' by q' (METHOD 3.2-3.3). */
struct PlaneMeasurement {
  Eigen::Vector3d h;
  Matrix36d H;
  Eigen::Matrix3d W;
};

/** \brief Evaluates the measurement; false if the normals differ by more than the given cosine allows. */
bool measurePlane(const Segment& scene, const Segment& model, const Eigen::Isometry3d& T_m_c,
                  double min_cosine, PlaneMeasurement& out);

/** \brief Squared Mahalanobis distance of the offset h_3 alone, with its variance enlarged by slack^2 [m^2].
 * Never larger than by all three components, and much cheaper: it rejects most pairs before anything
 * else is computed. */
double offsetDistance(const Segment& scene, const Segment& model, const PoseWithCovariance& T_m_c,
                      double slack = 0);

/** \brief Squared Mahalanobis distance d^2 = h^T (H P H^T + W)^-1 h under the pose uncertainty P
 * (METHOD 3.4), ~ chi2(3) for a correct pair. */
double innovationDistance(const PlaneMeasurement& m, const Matrix6d& P);

/** \brief Where two segments are that overlap, along their common plane (METHOD 6.6): the distance of the
 * centroids of the parts that either view shows, in the axes x' and y' of the model segment. It fixes
 * the motions that the planes of small surfaces leave free; for large ones it has little information. */
struct ExtentMeasurement {
  Eigen::Vector2d h;              ///< distance of the centroids [m]
  Eigen::Matrix<double, 2, 6> H;  ///< dh/dw by a left, decoupled perturbation of T_m_c
  Eigen::Matrix2d W;              ///< variance of h among all positions at which the two overlap [m^2]
};

/** \brief The measurement at a pose. */
ExtentMeasurement measureExtent(const Segment& scene, const Segment& model, const Eigen::Isometry3d& T_m_c);

/** \brief H^T W^-1 H; zero where W is singular. */
Matrix6d informationOf(const ExtentMeasurement& m);

/** \brief Coplanarity criterion: d^2 of the pair under the pose uncertainty. Infinity if the normals are
 * further apart than the cosine allows, or if d^2 certainly exceeds the gate. */
double coplanarityDistance(const Segment& scene, const Segment& model, const PoseWithCovariance& T_m_c,
                           double gate = std::numeric_limits<double>::infinity(), double min_cosine = 0);

/** \brief Overlap criterion (METHOD 4.2): squared Mahalanobis distance of the centroids under shapes and
 * pose; the shape of each counts as its 50 % ellipse, the pose at full uncertainty. Beyond the gate it may be
 * a lower bound of it. */
double overlapDistance(const Segment& scene, const Segment& model, const PoseWithCovariance& T_m_c,
                       double gate = std::numeric_limits<double>::infinity());

}  // namespace facetloc::internal
