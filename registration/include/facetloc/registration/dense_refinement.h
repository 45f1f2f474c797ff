// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_picture.h>
#include <facetloc/features/params.h>
#include <facetloc/features/so3.h>

#include <vector>

namespace facetloc {

/** \brief How a pose that planes have found is refined by all pixels. */
struct DenseRefinementParams {
  int iterations = 6;
  double pixel_error = 1.6;  ///< of a difference of two inverse depths [noise std]: sqrt 2 and the distortion
  double robust_gate = 3.0;  ///< differences beyond so many errors lose their weight
  double correlated_pixels = 1;  ///< so many pixels tell as much as one: neighbours err alike
  double significance = 0;  ///< least information of a direction [that of the gradients' noise]; 0 = no test

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("dense_iterations", p.iterations, 1, 100, "Gauss-Newton steps of the dense refinement.");
    field("dense_pixel_error", p.pixel_error, 0.1, 1e3,
          "Error of a difference of two inverse depths [noise standard deviations].");
    field("dense_robust_gate", p.robust_gate, 0.1, 100.0,
          "Differences of inverse depth beyond this many errors lose their weight.");
    field("dense_correlated_pixels", p.correlated_pixels, 1.0, 1e6,
          "Number of pixels that together tell as much as one with independent errors.");
    field("dense_significance", p.significance, 0.0, 1e6,
          "Information below which a direction is left to the prior [that of the gradients' noise].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief A depth picture and where its camera was. */
struct PosedPicture {
  const DepthPicture* picture;
  Eigen::Isometry3d T_w_c;
};

/** \brief Refines the pose of a scene by the inverse depths of pictures whose poses are known: moves a grid
 * of the scene's pixels into each of them and reduces the differences there, robustly, the plane-based
 * estimate being the prior.
 *
 * A plane has an inverse depth that is linear in the pixel, so that a difference of inverse depths divided by
 * the noise is the same measurement everywhere in the image. A pixel may at first differ by what the prior's
 * covariance predicts, and in the end by the sensor's error alone.
 *
 * \param inverse_depth_std noise of inverse depth [1/m]
 * \param pose T_w_c of the scene, which is updated, and its covariance, which is the prior and stays as it
 *        is: these are the pixels that the planes were fitted to, not new ones
 * \param information if given, what the pixels tell of the pose found, without the prior: the inverse of the
 *        covariance that they alone would give
 * \return false, and no change, if no picture shares pixels with the scene. */
bool refineByDepth(const DepthPicture& scene, const std::vector<PosedPicture>& pictures,
                   double inverse_depth_std, const DenseRefinementParams& params, PoseWithCovariance& pose,
                   Matrix6d* information = nullptr);

}  // namespace facetloc
