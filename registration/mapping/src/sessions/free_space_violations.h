// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/depth_consistency.h"

#include <facetloc/features/local_model.h>

#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief The evidence of later views about the surfaces of one local model. */
struct SurfaceReview {
  std::vector<char> gone;  ///< for each pixel of its depth picture: it is looked through
  int judged = 0;          ///< pixels that a later view agrees with or looks through
  int gone_pixels = 0;
  std::vector<int> gone_segments;                        ///< indices, ascending
  std::vector<std::vector<std::size_t>> gone_pixels_of;  ///< for each gone segment: those looked through
  int judged_segments = 0;

  double goneShare() const { return judged > 0 ? gone_pixels / double(judged) : 0; }
};

/** \brief Judges the surfaces of a local model by free space: a pixel is gone if at least `looks` of the
 * views look through it, and more than agree with it; a segment is gone if most of its judged pixels are.
 *
 * A surface behind another object is hidden, not gone: a passer-by changes nothing.
 * \param others pictures of later views from different places, T_w_c = pose in the model's frame */
SurfaceReview reviewSurfaces(const View& model, const std::vector<PosedPicture>& others,
                             const DepthComparison& comparison, int looks);

/** \brief The share of some pixels of a picture that each other view looks through, of those that it looks
 * through or agrees with; nothing for a view without any of these. */
std::vector<std::optional<double>> sharesLookedThrough(const DepthPicture& picture,
                                                       const std::vector<std::size_t>& pixels,
                                                       const std::vector<PosedPicture>& others,
                                                       const DepthComparison& comparison);

/** \brief The view without its gone surfaces. Segments that stay keep all of their pixels. */
View withoutGone(const View& model, const SurfaceReview& review);

}  // namespace facetloc::internal
