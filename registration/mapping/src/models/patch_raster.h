// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_picture.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace facetloc::internal {

/** \brief The surface that one depth picture shows, as a patch of a plane for each pixel.
 *
 * The plane of a pixel is fitted to the inverse depths of its 5x5 neighbours, in which planes are linear:
 * those across a silhouette are left out, and the noise of one pixel does not decide which way a patch faces.
 * A point p of the picture's optical frame lies on the plane if m . p = 1. */
struct SurfacePatches {
  Intrinsics camera;        ///< intrinsics of the picture
  Eigen::Isometry3d T_w_c;  ///< pose of its camera
  DepthNoise noise;         ///< noise of its pixels
  /// plane m of each pixel, row-major [1/m]; 0 where it is unknown or shows no surface
  std::vector<Eigen::Vector3f> patch;
  Eigen::AlignedBox3d box;  ///< box around the patches, in the world

  const Eigen::Vector3f& at(int u, int v) const {
    return patch[static_cast<std::size_t>(v) * camera.width + u];
  }
};

/** \param left_out of each pixel: it shows no surface. Empty: none is */
SurfacePatches patchesOf(const PosedPicture& picture, const std::vector<char>& left_out);

/** \brief A depth image of a surface, and how well it is known. */
struct RenderedDepth {
  DepthImage image;
  /// Root mean square of the differences of several pictures that show a pixel, in their own noise: above 1,
  /// their poses err, or something that none of them says.
  double disagreement = 0;
  double knownShare() const;  ///< share of its pixels
};

/** \brief Draws patches of several pictures into the image of another camera. Each pixel keeps all
 * values drawn there, until resolve() finds the nearest surface and the values that belong to it. */
class PatchRaster {
public:
  PatchRaster(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c);

  /** \brief Draws each step-th pixel of a picture, in both directions, as large as step pixels. */
  void draw(const SurfacePatches& picture, int step);
  RenderedDepth resolve() const;

private:
  struct Fragment {
    std::uint32_t pixel;
    float rho;    // inverse depth [1/m]
    float error;  // its standard deviation [1/m]
    bool front;   // the surface is seen from the side that the picture saw
  };
  struct Quad;
  void fill(const Quad& quad, float largest);

  Intrinsics camera_;
  Eigen::Isometry3d T_c_w_;
  std::vector<Fragment> fragments_;
};

}  // namespace facetloc::internal
