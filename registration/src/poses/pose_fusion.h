// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>

namespace facetloc::internal {

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
/** \brief With these added. */
Matrix6d withSharedErrors(Matrix6d P);

}  // namespace facetloc::internal
