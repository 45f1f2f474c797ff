// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_picture.h>

#include <Eigen/Geometry>

#include <vector>

namespace facetloc::internal {

/** \brief The surface that one depth picture shows, as a patch of a plane for each pixel.
 *
 * The plane of a pixel is fitted to the inverse depths of its 5x5 neighbours, in which planes are linear:
 * those across a silhouette are left out, and the noise of one pixel does not decide which way a patch faces.
 * A point p of the picture's optical frame lies on the plane if m . p = 1. */
struct SurfacePatches {
  struct Patch {
    float m_x = 0, m_y = 0, m_z = 0;  ///< plane [1/m]; all 0 where the pixel is unknown or shows no surface
    bool known() const { return m_x != 0 || m_y != 0 || m_z != 0; }
  };

  Intrinsics camera;         ///< intrinsics of the picture
  Eigen::Isometry3d T_w_c;   ///< pose of its camera
  DepthNoise noise;          ///< noise of its pixels
  std::vector<Patch> patch;  ///< row-major
  Eigen::AlignedBox3d box;   ///< box around the patches, in the world

  const Patch& at(int u, int v) const { return patch[static_cast<std::size_t>(v) * camera.width + u]; }
};

/** \param left_out of each pixel: it shows no surface. Empty: none is */
SurfacePatches patchesOf(const PosedPicture& picture, const std::vector<char>& left_out);

}  // namespace facetloc::internal
