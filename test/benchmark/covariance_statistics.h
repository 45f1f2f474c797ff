// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/evaluation.h"

#include <facetloc/features/pose.h>

#include <array>
#include <cstddef>
#include <vector>

namespace facetloc::benchmarks {

/** \brief How the errors of poses compare with the covariances that are stated. */
class CovarianceStatistics {
public:
  /** \brief The three principal axes of a stated position, by their variance. */
  enum Axis : std::size_t { weakest, middle, strongest };

  /** \brief One pose with its true value; leaves out a covariance that is not positive definite.
   * \param truth covariance of the true value's own error, independent of the pose's */
  void add(const PoseWithCovariance& pose, const Eigen::Isometry3d& T_true, const Matrix6d& truth);

  std::size_t size() const { return nees_.size(); }
  std::size_t invalid() const { return invalid_; }  ///< left out
  /** \brief Mean of e^T P^-1 e: 6 if covariances are right. 0 without poses. */
  double meanNees() const { return Sample(nees_).mean; }
  /** \brief The value that this share of e^T P^-1 e does not exceed; 5.35 for a half if they are right. */
  double nees(double share) const { return Sample(nees_).bound(share); }
  /** \brief Share of the poses whose true value lies in the ellipsoid that should hold 50 or 95 % of them. */
  double inside50() const { return inside(kEllipsoid50); }
  double inside95() const { return inside(kEllipsoid95); }
  /** \brief The value that this share of |error| / std along an axis does not exceed: 0.67, 1.64 and 2.17 for
   * 0.5, 0.9 and 0.97 if covariances are right. */
  double ratio(Axis axis, double share) const { return Sample(ratios_[axis]).bound(share); }

private:
  static constexpr double kEllipsoid50 = 5.348, kEllipsoid95 = 12.592;  // chi squared, 6 degrees of freedom
  double inside(double ellipsoid) const;

  std::vector<double> nees_;
  std::array<std::vector<double>, 3> ratios_;
  std::size_t invalid_ = 0;
};

/** \brief Covariance of true poses, of which the errors' root mean squares are known, as angle [deg] and
 * distance [mm]: the same along all axes. */
Matrix6d covarianceOfTruth(double rotation_deg, double translation_mm);

}  // namespace facetloc::benchmarks
