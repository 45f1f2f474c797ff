// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_picture.h>
#include <facetloc/features/pose.h>

namespace facetloc::internal {

/** \brief Normal equations of a pose T_w_c by all pixels of its depth picture against other pictures:
 * residuals of inverse depth, weighed robustly, by its left perturbation. */
struct DepthNormalEquations {
  Matrix6d A = Matrix6d::Zero();  ///< lower triangle
  Vector6d g = Vector6d::Zero();
  double weight = 0;                  ///< sum of the robust weights
  bool of_noise = false;              ///< whether noise is wanted
  Matrix6d noise = Matrix6d::Zero();  ///< expected contribution to A of noise with unit variance of the
                                      ///< gradients; lower triangle

  /** \brief Adds the measurements of a picture taken at T_w_m.
   * \param step distance of the scene's pixels that are compared
   * \param uncertainty covariance of T_w_c, by which residuals may be larger than by the error alone
   * \param error standard deviation of a difference of inverse depths [1/m]
   * \param gate residuals beyond this number of standard deviations have little weight */
  void add(const DepthPicture& scene, int step, const Eigen::Isometry3d& T_w_c, const DepthPicture& picture,
           const Eigen::Isometry3d& T_w_m, const Matrix6d& uncertainty, double error, double gate);
  /** \brief Adds those of one picture. \param of_pixel information of one pixel, by which they are weighed
   * \param gradient_variance of that picture, by which its part of the noise is weighed, too */
  void add(const DepthNormalEquations& of_picture, double of_pixel, double gradient_variance) {
    A += of_pixel * of_picture.A;
    g += of_pixel * of_picture.g;
    noise += of_pixel * gradient_variance * of_picture.noise;
    weight += of_picture.weight;
  }
};

}  // namespace facetloc::internal
