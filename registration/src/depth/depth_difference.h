// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_picture.h>

#include <cmath>
#include <cstddef>

namespace facetloc::internal {

/** \brief The inverse depth that a picture has at a point between its pixels, and its gradient [1/m, 1/m/px].
 */
struct DepthSlope {
  static constexpr int kReach = 2;         ///< of the gradient to each side [px]
  static constexpr double kStraight = 12;  ///< errors that the second difference may have
  double value, du, dv;
};

/** \brief The picture is linear in inverse depth on planes; where it is not (edges, noise of curved things)
 * nothing is measured, and the result is false. \param error of a difference of inverse depths [1/m] */
inline bool depthSlopeAt(const DepthPicture& picture, double x, double y, double error, DepthSlope& slope) {
  constexpr int kReach = DepthSlope::kReach;
  const Intrinsics& c = picture.camera;
  const int u = static_cast<int>(std::floor(x + 0.5)), v = static_cast<int>(std::floor(y + 0.5));
  if (!(u >= kReach && v >= kReach && u < c.width - kReach && v < c.height - kReach)) return false;
  const auto at = [&](int column, int row) {
    return DepthPicture::kQuantum * picture.inverse_depth[static_cast<std::size_t>(row) * c.width + column];
  };
  const double centre = at(u, v);
  const double left = at(u - kReach, v), right = at(u + kReach, v);
  const double up = at(u, v - kReach), down = at(u, v + kReach);
  if (centre == 0 || left == 0 || right == 0 || up == 0 || down == 0) return false;
  const double tolerance = DepthSlope::kStraight * error;
  if (std::abs(left + right - 2 * centre) > tolerance || std::abs(up + down - 2 * centre) > tolerance)
    return false;
  slope.du = (right - left) / (2 * kReach), slope.dv = (down - up) / (2 * kReach);
  // The mean of the five is the value of their plane at the centre.
  slope.value = (centre + left + right + up + down) / 5 + slope.du * (x - u) + slope.dv * (y - v);
  return true;
}

/** \brief A point that one depth picture has measured, beside what another picture measured there. */
struct DepthDifference {
  static constexpr double kNearest = 0.5;  ///< points nearer than this are outside the sensor's range [m]
  static constexpr double kFarthest =
      1 / 8.0;               ///< smallest inverse depth used where poses are estimated [1/m]
  double inverse_depth;      ///< of the point in the other picture's camera [1/m]
  double x, y;               ///< the ray (b_x, b_y) on which it lies there
  double residual;           ///< inverse_depth minus that of the picture [1/m]
  Eigen::Vector3d by_point;  ///< derivative of the residual by the point in that camera's axes [1/m^2]
};

/** \param ray of the point in its own camera, in the axes of the other one
 * \param t centre of its own camera in the other one [m]
 * \param inverse_depth that it has in its own camera [1/m]
 * \param error of a difference of inverse depths [1/m]
 * \return false where there is nothing to compare */
inline bool compareDepth(const Eigen::Vector3d& ray, const Eigen::Vector3d& t, double inverse_depth,
                         const DepthPicture& picture, double error, DepthDifference& out) {
  const Eigen::Vector3d p = ray + t * inverse_depth;  // times the depth: the point
  if (!(p.z() > DepthDifference::kNearest * inverse_depth)) return false;
  const Intrinsics& c = picture.camera;
  out.inverse_depth = inverse_depth / p.z();
  out.x = p.x() / p.z(), out.y = p.y() / p.z();
  DepthSlope slope;
  if (!depthSlopeAt(picture, c.fx * out.x + c.cx, c.fy * out.y + c.cy, error, slope)) return false;
  // Gradient of the residual by the point in the model's frame; a plane's normal up to scale.
  const double gx = slope.du * c.fx, gy = slope.dv * c.fy;
  out.by_point = out.inverse_depth * Eigen::Vector3d(-gx, -gy, -out.inverse_depth + gx * out.x + gy * out.y);
  out.residual = out.inverse_depth - slope.value;
  return true;
}

}  // namespace facetloc::internal
