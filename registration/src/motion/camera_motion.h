// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "motion/step_prior.h"
#include "motion/view_odometry.h"
#include "motion/view_placing.h"

#include <memory>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief A motion T_a_b that two images and the prior leave open. */
struct MotionMode {
  PoseWithCovariance T_a_b;
  double probability = 1;  ///< beside the other modes
};

/** \brief The motion of a camera from one image to the next, T_a_b: a = before, b = now. */
struct Motion {
  enum class Source {
    seen,     ///< measured in the images or by a given odometry
    guessed,  ///< the images show nothing of it: as far as a camera may have moved
    broken    ///< the images deny any motion that a camera makes in that time
  };
  std::vector<MotionMode> modes{MotionMode{}};  ///< likeliest first, never empty
  Source source = Source::guessed;
  double agreement = 0;  ///< share of the depth pixels that confirm the likeliest mode; 0 if unknown
  double none = 0;       ///< probability that the camera did something else than any of the modes

  /** \brief One answer, whoever has given it. */
  static Motion known(const PoseWithCovariance& T_a_b) { return {{{T_a_b, 1}}, Source::seen}; }
  const PoseWithCovariance& likeliest() const { return modes.front().T_a_b; }
};

/** \brief Finds how a camera moves from image to image, at any frame rate.
 *
 * Images in quick succession are followed by ViewOdometry. Others, and those that it cannot follow, are
 * placed relative to the image before (ViewPlacing), within the largest motion of a camera in that time or
 * about the motion of a given odometry; such a motion may have several answers. */
class CameraMotion {
public:
  explicit CameraMotion(const ViewOdometryParams& params);

  void reset();
  /** \param dt time since the image before [s] \param given motion since then, by another odometry */
  Motion next(const std::shared_ptr<const View>& view, double dt,
              const std::optional<PoseWithCovariance>& given = {});

private:
  Motion placed(const View& view, const PoseWithCovariance& prior, bool quick) const;

  ViewOdometry odometry_;
  ViewPlacing placing_;
  VelocityPrior velocity_;
  std::shared_ptr<const View> before_;
};

}  // namespace facetloc::internal
