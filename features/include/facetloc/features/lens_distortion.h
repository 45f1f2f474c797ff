// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <vector>

namespace facetloc {

/** \brief Distortion of a lens, OpenCV's rational model. A ray (x, y, 1) with r^2 = x^2 + y^2 is seen where a
 * pinhole camera would see
 *
 *     x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
 *     y' = y (the same)                                                      + p1 (r^2 + 2 y^2) + 2 p2 x y
 *
 * All zero: a pinhole camera. */
struct LensDistortion {
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0;  ///< radial
  double p1 = 0, p2 = 0;                                  ///< tangential

  bool isNone() const;
  /** \brief (x', y') of a ray. */
  Eigen::Vector2d distorted(const Eigen::Vector2d& ray) const;
  /** \brief The ray that is seen at (x', y'); empty if no ray within largestRadius() is. */
  std::optional<Eigen::Vector2d> undistorted(const Eigen::Vector2d& seen) const;
  /** \brief The r up to which rays farther out are seen farther out, so that the model can be inverted; at
   * most 10. */
  double largestRadius() const;

  bool operator==(const LensDistortion& o) const;
  bool operator!=(const LensDistortion& o) const { return !(*this == o); }
};

/** \brief Meaning of the pixels of a depth image. */
enum class DepthKind {
  z,         ///< the distance from the camera's plane
  distance,  ///< the distance from the camera, along the ray
};

/** \brief Makes a pinhole camera's depth images of those of a camera with a lens, or of distances along rays.
 *
 * The pinhole image has the same intrinsics. Each of its pixels takes the depth of the nearest pixel of the
 * image, moved by less than a pixel along the surface as far as both neighbours of that pixel are on it:
 * depths on both sides of an edge are never mixed. Pixels that the lens does not show are 0. Const calls are
 * thread-safe. */
class LensCorrection {
public:
  /** \param camera of the images, which have to be of its size. Throws std::invalid_argument if it is not
   * valid(). */
  LensCorrection(const Intrinsics& camera, const LensDistortion& lens, DepthKind kind = DepthKind::z);

  const Intrinsics& camera() const { return camera_; }
  /** \brief An image of another size or without the right number of pixels becomes an empty one. */
  DepthImage operator()(const DepthImage& image) const;

private:
  struct Source {
    std::int32_t pixel = -1;  // index in the image; -1 = none
    float du = 0, dv = 0;     // offset from its centre [px]
  };
  std::vector<float> inverseDepths(const DepthImage& image) const;

  Intrinsics camera_;
  std::vector<Source> sources_;  // one for each pixel of the pinhole image; empty: the same pixel
  std::vector<float>
      inverse_factor_;  // one for each pixel of the image: inverse z by inverse distance; empty: 1
};

}  // namespace facetloc
