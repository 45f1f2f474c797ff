// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief Noise of inverse depth, estimated from the image itself [1/m] (segmentation/METHOD 2.2): the median
 * absolute second difference along rows over triples of valid pixels in 60 to 119 rows from all over the
 * image (in all of a lower one), scaled for white noise. Smooth noise, as a stereo camera has it, hardly
 * differs between neighbours: half of the estimate from triples of pixels 6 apart (at 320 columns) counts
 * too, if it is more, which it is not for a Kinect. Not less than the given one, which is returned for fewer
 * than 100 triples. */
double estimateNoise(const DepthImage& image, double least = 0);
/** \brief The same with memory that is kept from image to image. */
double estimateNoise(const DepthImage& image, double least, std::vector<float>& scratch);

/** \brief Noise that neighbouring pixels share, as a stereo camera has it: a wall becomes wavy rather than
 * rough. Its correlation over the distance r is exp(-r^2 / correlation_px^2). */
struct SmoothNoise {
  double std;             ///< standard deviation of inverse depth [1/m]
  double correlation_px;  ///< [px of the image]
};

/** \brief Looks how the second differences of an image grow with the distance of the pixels
 * (segmentation/METHOD 2.3). None if neighbours differ about as much as pixels farther apart, as for a
 * Kinect. */
std::optional<SmoothNoise> estimateSmoothNoise(const DepthImage& image, std::vector<float>& scratch);

/** \brief Both: raises the noise of inverse depth [1/m] and its correlation length [px at 320x240] to the
 * values that the image shows. */
void measureNoise(const DepthImage& image, double& noise, double& correlation_px,
                  std::vector<float>& scratch);

}  // namespace facetloc::internal
