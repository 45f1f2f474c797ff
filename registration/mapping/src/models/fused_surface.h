// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "models/patch_raster.h"
#include "models/seen_space.h"

#include <facetloc/mapping/surface.h>

#include <vector>

namespace facetloc::internal {

/** \brief The surface that the depth pictures of a map show together.
 *
 * A pixel of a picture counts unless more pictures look through it than agree with it: moved objects are left
 * out, surfaces hidden from the others stay. Where several pictures show a point of a rendered image, it has
 * their mean, each by its own error. A pixel is unknown where the nearest surface is seen from behind, where
 * nothing was seen, and where the way to the surface leads through space that no picture has looked into. */
class FusedSurface final : public Surface {
public:
  /** \param pictures of known poses; they must outlive it \param threads 0 = all cores */
  FusedSurface(const std::vector<PosedPicture>& pictures, int threads);

  DepthImage render(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const override;
  Eigen::AlignedBox3d bounds() const override { return bounds_; }
  /** \brief The same with its errors. \param step every step-th pixel of the pictures is taken, in both
   * directions: for a first look */
  RenderedDepth renderWithErrors(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c,
                                 int step = 1) const;
  const SeenSpace& space() const { return space_; }
  double contradictedShare() const { return contradicted_; }  ///< share of all pixels that are left out

private:
  std::vector<std::size_t> sourcesFor(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const;

  std::vector<SurfacePatches> pictures_;
  SeenSpace space_;
  Eigen::AlignedBox3d bounds_;
  double contradicted_ = 0;
};

}  // namespace facetloc::internal
