// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment.h>

#include <random>

/** \file
 * Random poses, planes and disturbances for property tests; a seed gives the same numbers on every run. */
namespace facetloc::test {

using Rng = std::mt19937;

double uniform(Rng& rng, double low, double high);

/** \brief A vector of independent N(0, 1); N is 1, 2, 3 or 6. */
template <int N>
Eigen::Matrix<double, N, 1> gaussian(Rng& rng);

/** \brief A draw of N(0, Sigma); N is 3 or 6. */
template <int N>
Eigen::Matrix<double, N, 1> gaussian(Rng& rng, const Eigen::Matrix<double, N, N>& Sigma);

Eigen::Vector3d randomDirection(Rng& rng);

/** \brief Any rotation, uniformly in angle about a random axis. */
Eigen::Matrix3d randomRotation(Rng& rng, double max_angle = 3.14);

Eigen::Isometry3d randomPose(Rng& rng, double max_angle, double max_distance);

/** \brief A random covariance with the given standard deviations and moderate correlations; N is 3 or 6. */
template <int N>
Eigen::Matrix<double, N, N> randomCovariance(Rng& rng, const Eigen::Matrix<double, N, 1>& std);

ConvexHull rectangleHull(double half_x, double half_y);

/** \brief A rectangular segment with consistent shape, outline and a plain diagonal uncertainty.
 *
 * The longer side runs along x of S_F, turned by the given angle about the normal. */
Segment rectangle(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double half_x, double half_y,
                  double turn = 0, double slope_std = 0.01, double offset_std = 0.01);

/** \brief A plausible segment: 1 to 5 m in front of the camera, 0.2 to 2 m large, not edge-on, with a full
 * Sigma_q. */
Segment randomSegment(Rng& rng);

/** \brief Where the true plane of a segment is measured with the error q: the true plane has the disturbance
 * q in the returned segment's frame (paper, eqs. (2)-(3)). */
Segment disturbed(const Segment& truth, const Eigen::Vector3d& q);

/** \brief Another part of the same plane: the segment moved within its plane and turned about its normal. */
Segment movedInPlane(const Segment& s, double x, double y, double turn);

/** \brief A random other part of the same plane, up to so far away [m], its axes turned anyhow. */
Segment anotherPart(Rng& rng, const Segment& s, double max_x, double max_y);
Segment anotherPart(Rng& rng, const Segment& s, double max_shift);

/** \brief True if two segments are the same in every number. */
bool sameNumbers(const Segment& a, const Segment& b);

/** \brief A point of a cube about the origin. */
Eigen::Vector3d uniformVector(Rng& rng, double half_side);

}  // namespace facetloc::test
