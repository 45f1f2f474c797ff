// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/depth_image.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Bend of surfaces that ought to be flat (mapping/METHOD 15.1). */
struct SurfaceBend {
  double ray_exponent = 0;      ///< depths as read are z times this power of the length of the ray (b_z = 1):
                                ///< 0 for z, 1 for distances along the rays
  double ray_exponent_std = 0;  ///< standard deviation, from the scatter over the images
  double lens = 0;              ///< k1 of a radial lens whose distortion is left in the images
  double lens_std = 0;
  double residual_ratio = 1;  ///< sum of squared residuals without the bend, by that with it
  double flat_share = 0;      ///< expected share of the image that the surface of a pixel covers
};

/** \brief Intrinsics by which most surfaces that are nearly perpendicular are exactly so (METHOD 15.2). */
struct RightAngles {
  std::size_t pairs = 0;                         ///< pairs of surfaces, each in one image
  double share_as_given = 0, share_by_best = 0;  ///< weight of the pairs that are perpendicular
  double fx = 1, fy = 1;                         ///< the best ones, by the given ones
  double cx = 0, cy = 0;                         ///< the best ones minus the given ones [px]
  double fx_std = 0, fy_std = 0, cx_std = 0, cy_std = 0;
};

/** \brief A reason to doubt how depth images are read. */
struct ReadingFault {
  std::string words;        ///< the finding and its remedy: a sentence without full stop
  bool impossible = false;  ///< the images cannot be right as they are read
};

/** \brief Evidence in depth images alone of how they must be read. */
struct GeometryCheck {
  std::size_t images = 0, surfaces = 0;  ///< that were looked at
  SurfaceBend bend;
  std::optional<RightAngles> right_angles;  ///< nothing if there are too few pairs
  std::vector<ReadingFault> faults;         ///< the clearest first

  /** \brief The first fault that makes the images impossible; null if they are possible. */
  const ReadingFault* impossible() const;
};

/** \brief Tests the largest flat surfaces of some images of one camera: whether they are flat as read, as
 * distances along the rays, or behind a lens; and whether those that are about perpendicular are so with the
 * intrinsics of the images, or with other ones.
 *
 * A plane stays a plane whatever fx, fy, cx and cy are; these show in the angles between planes only.
 * \param images as they are worked on, valid, of one size; some dozen, from all over a recording */
GeometryCheck checkGeometry(const std::vector<DepthImage>& images, const Camera& camera);

}  // namespace facetloc
