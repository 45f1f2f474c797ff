// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_picture.h>
#include <facetloc/features/pose.h>

#include <vector>

namespace facetloc::internal {

/** \brief How a pose that planes have found is refined by all pixels (METHOD 11). */
struct DenseRefinementParams {
  int iterations = 6;  ///< Gauss-Newton steps at most
  double pixel_error =
      1.6;  ///< error of a difference of inverse depths [noise std]: sqrt 2 and the distortion
  double robust_gate = 3.0;      ///< difference at which a pixel loses its weight [errors]
  double correlated_pixels = 1;  ///< that count as one independent measurement
  double significance = 0;       ///< least information of a direction [the gradients' noise]; 0 = no test
};

/** \brief Refines the pose of a scene by the inverse depths of pictures whose poses are known: moves a grid
 * of the scene's pixels into each of them and reduces the differences there, robustly, the plane-based
 * estimate being the prior.
 *
 * A plane has an inverse depth that is linear in the pixel, so that a difference of inverse depths divided by
 * the noise is the same measurement everywhere in the image. A pixel may at first differ as far as the
 * prior's covariance predicts, and in the end by the sensor's error alone.
 *
 * \param pose T_w_c of the scene, which is updated, and its covariance, which is the prior and stays as it
 *        is
 * \param information if given, receives the information of the pixels about the pose found, without the
 * prior: the inverse of the covariance that they alone would give \return false, and no change, if no picture
 * shares pixels with the scene. */
bool refineByDepth(const DepthPicture& scene, const std::vector<PosedPicture>& pictures,
                   const DenseRefinementParams& params, PoseWithCovariance& pose,
                   Matrix6d* information = nullptr);

}  // namespace facetloc::internal
