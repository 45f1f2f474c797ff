// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "motion/view_odometry.h"
#include "motion/view_placing.h"

#include <memory>
#include <optional>

namespace facetloc::internal {

/** \brief Tells how a camera has moved from image to image, of a film or of images that are far apart.
 *
 * Images in quick succession are followed by ViewOdometry. Others, and those that it cannot follow, are
 * placed beside the image before (ViewPlacing), about any motion within a step or about the one of an
 * odometry which is given. */
class ImageMotion {
public:
  explicit ImageMotion(const ViewOdometryParams& params);

  void reset();
  /** \param dt since the image before [s] \param given motion since then, by another odometry
   * \return broken if the views deny any motion of one step and no other odometry knows one; where they
   * say nothing, what else is known, and no agreement */
  ViewMotion add(const std::shared_ptr<const View>& view, double dt,
                 const std::optional<PoseWithCovariance>& given);

private:
  std::optional<PoseWithCovariance> placed(const View& view, const PoseWithCovariance& prior, bool quick,
                                           double& agreement) const;

  ViewOdometry odometry_;
  ViewPlacing placing_;
  std::shared_ptr<const View> before_;
};

}  // namespace facetloc::internal
