// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/depth_consistency.h"

#include <facetloc/features/local_model.h>

#include <vector>

namespace facetloc::internal {

/** \brief What later views say of the surfaces of one local model. */
struct SurfaceReview {
  std::vector<char> gone;  ///< of each pixel of its depth picture: it is looked through
  int judged = 0;          ///< pixels that a later view agrees with or looks through
  int gone_pixels = 0;
  std::vector<int> gone_segments;  ///< indices, ascending
  int judged_segments = 0;

  double goneShare() const { return judged > 0 ? gone_pixels / double(judged) : 0; }
};

/** \brief Judges the surfaces of a local model by free space: a pixel is gone if at least so many of the
 * views look through it, and more than agree with it; a segment is gone if most of its pixels are that say
 * anything.
 *
 * A surface that something stands in front of is hidden, not gone: who passes by changes nothing.
 * \param others pictures of later views from different places, T_w_c = pose in the model's frame */
SurfaceReview reviewSurfaces(const View& model, const std::vector<PosedPicture>& others,
                             const DepthComparison& comparison, int looks);

/** \brief The view without what is gone. Segments that stay keep all of their pixels. */
View withoutGone(const View& model, const SurfaceReview& review);

}  // namespace facetloc::internal
