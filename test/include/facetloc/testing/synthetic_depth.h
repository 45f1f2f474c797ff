// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <vector>

/** \file
 * A depth camera of a few lines: exact depth and labels of rectangles and endless planes. */
namespace facetloc::test {

/** \brief 320x240 with different focal lengths, as all tests that do not care use it. */
Intrinsics smallCamera();
/** \brief 160x120, for tests that look at every pixel many times. */
Intrinsics tinyCamera();

/** \brief A rectangle in space, or the whole plane if a half side is zero. */
struct Face {
  Eigen::Vector3d centre, x, y;  ///< x, y: unit vectors along the sides
  double half_x = 0, half_y = 0;
};

using Scene = std::vector<Face>;

Face endlessPlane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal);

/** \brief The six faces of an axis-parallel box: a room seen from inside, furniture seen from outside. */
Scene box(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

Scene operator+(Scene a, const Scene& b);

/** \brief An image and, per pixel, which face it shows (counted from 1, 0 = none). */
struct Rendering {
  DepthImage image;
  LabelImage labels;
};

Rendering render(const Scene& scene, const Intrinsics& camera,
                 const Eigen::Isometry3d& T_w_c = Eigen::Isometry3d::Identity(), double farthest = 20);

/** \brief The image with other measured depths. \param change returns one by (depth, ray with z = 1) */
template <class Change>
DepthImage changedDepth(DepthImage image, const Change& change) {
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      float& z = image.depth[static_cast<std::size_t>(v) * image.camera.width + u];
      if (isMeasured(z)) z = static_cast<float>(change(z, image.camera.ray(u, v)));
    }
  return image;
}

/** \brief The image with white noise [1/m] on its inverse depth. */
DepthImage noisy(DepthImage image, double inverse_depth_std, unsigned seed);

/** \brief The same with smooth noise, as a stereo camera has it: white noise averaged with Gaussian weights
 * of that standard deviation [px]. */
DepthImage smoothlyNoisy(DepthImage image, double inverse_depth_std, double smoothing, unsigned seed);

/** \brief The image with its disparity rounded to whole Kinect units. */
DepthImage rounded(DepthImage image);

/** \brief T_w_c of a camera at a point that looks along a direction, with y of the image towards the given
 * down. */
Eigen::Isometry3d lookingAlong(const Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                               const Eigen::Vector3d& down = -Eigen::Vector3d::UnitZ());

/** \brief A room of 4 x 5 x 2.5 m with two boxes, z up, origin at a lower corner. */
Scene furnishedRoom();

}  // namespace facetloc::test
