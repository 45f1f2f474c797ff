// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "models/surface_patches.h"

#include <facetloc/features/depth_image.h>

#include <cstdint>
#include <vector>

namespace facetloc::internal {

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
