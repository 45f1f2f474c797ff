// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>

/** \file
 * One pose of two: how near they are then, and the pose that two sources give together. */

namespace facetloc::internal {

/** \brief How far apart two poses may be to count as one: one of the radii below. */
struct PoseRadius {
  double distance;   ///< [m]
  double angle_deg;  ///< [deg]

  bool joins(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
    return isNear(a, b, distance, angle_deg);
  }
};

/** \brief A motion or a place that two sources agree on: views, an odometry. */
constexpr PoseRadius kSameMotion{0.05, 2};
/** \brief Hypotheses that are listed once. Below the tolerance that defines a correct pose, so that a wrong
 * neighbour cannot absorb the right one (localization/METHOD 1.2). */
constexpr PoseRadius kSamePlace{0.15, 2};
/** \brief Answers that do not exclude each other: one place, found more or less well
 * (localization/METHOD 1.4). */
constexpr PoseRadius kSameAnswer{0.3, 5};
/** \brief Images from there are no second look at a surface (mapping/METHOD 1.6). */
constexpr PoseRadius kSameLook{0.1, 5};
/** \brief A pose within is not another place (localization/METHOD 1.5). */
constexpr PoseRadius kSameSurroundings{1, 15};

/** \brief One pose by two sources with independent errors, the first not far from the second. */
PoseWithCovariance fused(const PoseWithCovariance& a, const PoseWithCovariance& b);

/** \brief One pose by two sources with an unknown correlation of their errors: covariance
 * intersection with the least determinant. Its covariance is never too small, and no larger than needed for
 * that (Julier, Uhlmann 1997). \param a, b with positive definite covariances, not far from each other */
PoseWithCovariance covarianceIntersection(const PoseWithCovariance& a, const PoseWithCovariance& b);

/** \brief The covariance of a posterior if the data added to the prior have only a part of the stated
 * information. \param prior, posterior positive definite \param part from 0 to 1 */
Matrix6d temper(const Matrix6d& prior, const Matrix6d& posterior, double part);

/** \brief Errors that any two views share, due to the space between them: standard deviations [rad, m]. */
constexpr double kSharedRotation = 0.05 * kDegree, kSharedTranslation = 0.003;
/** \brief With these, or others, added. */
Matrix6d withSharedErrors(Matrix6d P, double rotation_std = kSharedRotation,
                          double translation_std = kSharedTranslation);

}  // namespace facetloc::internal
