// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/lanes.h"

#include <facetloc/features/depth_picture.h>

#include <cmath>
#include <cstddef>

namespace facetloc::internal {

/** \brief A point that one depth picture has measured, and the measurement of another picture there.
 *
 * Number is double, or Floats for several points at once. The picture is taken as linear in inverse depth, as
 * it is on planes; its gradient comes from five pixels: centre, left, right, up and down of it. */
template <typename Number, typename Vector>
struct DepthDifferenceOf {
  static constexpr int kReach = 2;         ///< distance between the centre and the other pixels [px]
  static constexpr double kStraight = 12;  ///< errors that the second difference may have
  static constexpr double kNearest = 0.5;  ///< points nearer than this are outside the sensor's range [m]
  static constexpr double kFarthest =
      1 / 8.0;           ///< smallest inverse depth used where poses are estimated [1/m]
  Number inverse_depth;  ///< inverse depth of the point in the other picture's camera [1/m]
  Number x, y;           ///< the ray (b_x, b_y) on which it lies there
  Number residual;       ///< inverse_depth minus the picture's [1/m]
  Vector by_point;       ///< derivative of the residual by the point in that camera's axes [1/m^2]

  /** \brief Clears known where the five inverse depths are not linear (edges, noise of curved things).
   * \param error of a difference of inverse depths [1/m] */
  template <typename Scalar, typename Mask>
  FACETLOC_ALWAYS_INLINE static void dropBent(const Number (&five)[5], Scalar error, Mask& known) {
    const auto& [centre, left, right, up, down] = five;
    const Number bent_u = left + right - 2 * centre, bent_v = up + down - 2 * centre;
    const Scalar largest = static_cast<Scalar>(kStraight) * error;
    known &= (bent_u <= largest) & (bent_u >= -largest) & (bent_v <= largest) & (bent_v >= -largest);
  }

  /** \brief Sets residual and by_point, from inverse_depth, x and y.
   * \param five inverse depths of the picture [1/m]
   * \param off_u, off_v of the point from the centre of them [px]
   * \param fx, fy of the picture */
  template <typename Scalar>
  FACETLOC_ALWAYS_INLINE void setResidual(const Number (&five)[5], const Number& off_u, const Number& off_v,
                                          Scalar fx, Scalar fy) {
    const auto& [centre, left, right, up, down] = five;
    const Number du = (right - left) / (2 * kReach), dv = (down - up) / (2 * kReach);
    // The mean of the five is the value of their plane at the centre.
    const Number value = (centre + left + right + up + down) / 5 + du * off_u + dv * off_v;
    residual = inverse_depth - value;
    // Gradient of the residual by the point; a plane's normal up to scale.
    const Number gx = fx * du, gy = fy * dv;
    by_point[0] = -inverse_depth * gx;
    by_point[1] = -inverse_depth * gy;
    by_point[2] = inverse_depth * (gx * x + gy * y - inverse_depth);
  }
};

using DepthDifference = DepthDifferenceOf<double, Eigen::Vector3d>;

/** \param ray of the point in its own camera, in the axes of the other one
 * \param t centre of its own camera in the other one [m]
 * \param inverse_depth that it has in its own camera [1/m]
 * \param error of a difference of inverse depths [1/m]
 * \return false where there is nothing to compare */
inline bool compareDepth(const Eigen::Vector3d& ray, const Eigen::Vector3d& t, double inverse_depth,
                         const DepthPicture& picture, double error, DepthDifference& out) {
  constexpr int kReach = DepthDifference::kReach;
  const Eigen::Vector3d p = ray + t * inverse_depth;  // times the depth: the point
  if (!(p.z() > DepthDifference::kNearest * inverse_depth)) return false;
  const Intrinsics& c = picture.camera;
  out.inverse_depth = inverse_depth / p.z();
  out.x = p.x() / p.z(), out.y = p.y() / p.z();
  const double column = c.fx * out.x + c.cx, line = c.fy * out.y + c.cy;
  const int u = static_cast<int>(std::floor(column + 0.5)), v = static_cast<int>(std::floor(line + 0.5));
  if (!(u >= kReach && v >= kReach && u < c.width - kReach && v < c.height - kReach)) return false;
  const auto at = [&](int du, int dv) {
    return DepthPicture::kQuantum *
           picture.inverse_depth[static_cast<std::size_t>(v + dv) * c.width + u + du];
  };
  const double five[] = {at(0, 0), at(-kReach, 0), at(kReach, 0), at(0, -kReach), at(0, kReach)};
  bool known = true;
  for (const double d : five) known &= d != 0;
  DepthDifference::dropBent(five, error, known);
  if (known) out.setResidual(five, column - u, line - v, c.fx, c.fy);
  return known;
}

}  // namespace facetloc::internal
