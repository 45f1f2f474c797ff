// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/localization/localizer.h>
#include <facetloc/mapping/map_image.h>
#include <facetloc/registration/pose_prior.h>

#include <functional>
#include <optional>
#include <string>
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
  std::optional<PoseWithCovariance> until(double stamp);

private:
  PosesByTime odometry_;
  std::optional<CameraMounting> mounting_;
  OdometryError error_;
  std::optional<Eigen::Isometry3d> T_o_before_;
};

/** \brief Images of one drive, which are localized by each other, in their order. */
class Drive {
public:
  /** \param smoothing the images are kept, since later ones refine their poses. */
  Drive(Localizer localizer, MeasuredMotion motion, bool smoothing)
      : localizer_(std::move(localizer)), motion_(std::move(motion)), smoothing_(smoothing) {}

  /** \brief The answer by all images up to this one. */
  LocalizerAnswer add(std::size_t index, const View& view, double stamp);

  /** \brief Receives the answer for an image. */
  using Take = std::function<void(std::size_t index, const LocalizerAnswer& answer)>;
  /** \brief The answers to each of its images by all of them.
   * \param backward with the same map and parameters, has seen nothing yet
   * \param name of an image, for messages; throws Stopped at Ctrl-C */
  void smooth(Localizer& backward, const std::function<std::string(std::size_t index)>& name,
              const Console& console, const Take& take) const;

private:
  struct Image {
    std::size_t index;
    double stamp;
    View view;
    std::optional<PoseWithCovariance> T_before_now;  // motion by odometry
    LocalizerAnswer until_now;
  };

  Localizer localizer_;
  MeasuredMotion motion_;
  bool smoothing_;
  std::vector<Image> images_;
};

}  // namespace facetloc
