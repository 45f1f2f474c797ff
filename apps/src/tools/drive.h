// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/odometry_steps.h"

#include <facetloc/localization/localizer.h>
#include <facetloc/mapping/map_image.h>
#include <facetloc/registration/pose_prior.h>

#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief Motions of a camera from image to image, as an odometry has measured them. */
class MeasuredMotion {
public:
  /** \brief Nothing is measured. */
  MeasuredMotion() = default;
  /** \param odometry T_o_c by time; empty without odometry */
  MeasuredMotion(PosesByTime odometry, const std::optional<CameraMounting>& mounting,
                 const OdometryError& error)
      : odometry_(std::move(odometry)), mounting_(mounting), error_(error) {}

  /** \brief T_before_now since the last call; nothing at the first, and where the odometry has a gap. */
  std::optional<PoseWithCovariance> until(double stamp) {
    if (!odometry_) return {};
    const std::optional<Eigen::Isometry3d> T_before_now = steps_.to(odometry_(stamp));
    if (!T_before_now) return {};
    return motionByOdometry(*T_before_now, mounting_, error_);
  }

private:
  PosesByTime odometry_;
  std::optional<CameraMounting> mounting_;
  OdometryError error_;
  internal::OdometrySteps steps_;
};

/** \brief Images of one drive, which are localized by each other, in their order. */
class Drive {
public:
  /** \param smoothing the images are kept, since later ones refine their poses. */
  Drive(Localizer localizer, MeasuredMotion motion, bool smoothing)
      : localizer_(std::move(localizer)), motion_(std::move(motion)), smoothing_(smoothing) {}

  /** \brief The answer by all images up to this one. */
  Localization add(const View& view, double stamp) {
    const std::optional<PoseWithCovariance> motion = motion_.until(stamp);
    Localization answer = localizer_.update(view, stamp, motion);
    if (smoothing_) views_.push_back({view, stamp, motion, answer});
    return answer;
  }

  /** \brief The answers to its images by all of them, in the order of add(). \param done is called after each
   * image */
  std::vector<Localization> smoothed(const std::function<void()>& done) const {
    return localizer_.smoothed(views_, done);
  }

private:
  Localizer localizer_;
  MeasuredMotion motion_;
  bool smoothing_;
  std::vector<DriveView> views_;
};

}  // namespace facetloc
