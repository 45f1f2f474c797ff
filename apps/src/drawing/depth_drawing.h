// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/colours.h"

#include <facetloc/features/depth_image.h>
#include <facetloc/features/local_model.h>
#include <facetloc/io/png.h>

#include <string>
#include <vector>

namespace facetloc {

// Depth and segments pixel by pixel: the same on every machine, and without a display.

/** \brief How depth becomes grey: the nearest pixel is darkest, the farthest brightest, linear between. */
struct GreyScale {
  std::uint8_t darkest = 50;
  std::uint8_t brightest = 255;
  std::uint8_t unknown = 0;  ///< grey of pixels without a measurement
};

/** \brief An RGB picture of a depth image, of its size. */
Raster<std::uint8_t> greyDepth(const DepthImage& image, const GreyScale& scale = {});

/** \brief An RGB picture of the surfaces as a lamp at the camera would light them, of the size of the image:
 * the more they face the camera the brighter, black = not measured. */
Raster<std::uint8_t> litDepth(const DepthImage& image);

/** \brief Paints the outlines of segments over a picture of the same size as the labels.
 * \param colours of label k at k - 1 */
void paintBorders(Raster<std::uint8_t>& picture, const LabelImage& labels,
                  const std::vector<Colour>& colours);

/** \brief The paper's Fig. 1c: depth in grey, darker = closer, black = not measured, segment borders in
 * green. */
Raster<std::uint8_t> overlay(const DepthImage& image, const LabelImage& labels);

/** \brief Mixes the colour of each segment into a picture of the same size as the labels.
 * \param colours of label k at k - 1, alpha 0 = leave as it is; labels without one are left as they are. */
void paintSegments(Raster<std::uint8_t>& picture, const LabelImage& labels,
                   const std::vector<Colour>& colours);

/** \brief Depth of the small picture of a view [m], 0 where it is not known; without a picture, all unknown
 * at half the working size. */
DepthImage depthOf(const View& view);

/** \brief Where the segments of a view are seen, at the size of depthOf(view): label k = segment k - 1.
 *
 * A pixel belongs to the segment whose hull it lies in and whose plane its depth agrees with best; without a
 * depth picture, to the nearest segment in whose hull it lies. Single pixels follow their surroundings. */
LabelImage seenSegments(const View& view);

/** \brief Enlarged or reduced by taking the nearest pixel. */
Raster<std::uint8_t> resized(const Raster<std::uint8_t>& picture, int width, int height);
/** \brief Reduced by averaging n x n pixels; incomplete blocks at the right and at the bottom are dropped. */
Raster<std::uint8_t> averaged(const Raster<std::uint8_t>& picture, int n);

/** \brief The depth of a view as a small grey JPEG, darker = closer, black = not measured; empty for a view
 * without depth. \param width of the picture, at least; the depth picture is reduced by whole factors [px] */
std::string depthThumbnail(const View& view, int width);

}  // namespace facetloc
