// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <vector>

namespace facetloc::internal {

/** \brief Inverse depth in units of its own noise: a disparity image whose standard deviation is 1
 * everywhere.
 *
 * All segmentation is done here: planes of space are planes of (u, v, d), noise is homoscedastic, and
 * thresholds are plain multiples of the noise, whatever the sensor (METHOD 1). 0 = not measured; measured
 * values are positive. */
struct DisparityImage {
  Intrinsics camera;
  double unit = 1;  ///< inverse depth of one step [1/m]
  std::vector<float> d;
};

/** \brief Absolute second differences of inverse depth, in memory of their caller [1/m]. */
struct Differences {
  float *begin, *end;
  std::size_t size() const { return static_cast<std::size_t>(end - begin); }
  bool few() const { return size() < 100; }
};

/** \brief |x(u - apart) - 2 x(u) + x(u + apart)| wherever all three are measured, in about so many rows. */
Differences secondDifferences(const DepthImage& image, int apart, int rows, std::vector<float>& scratch);

/** \brief Noise of inverse depth by the median of such differences, as if it was white [1/m]; 0 if they are
 * few. */
double noiseByDifferences(const DepthImage& image, int apart, int rows, std::vector<float>& scratch);

/** \brief Noise of inverse depth, estimated from the image itself [1/m] (METHOD 2.2): the median absolute
 * second difference along rows over triples of valid pixels in 60 to 119 rows from all over the image (in all
 * of a lower one), scaled for white noise. Smooth noise, as a stereo camera has it, hardly differs between
 * neighbours: half of what triples of pixels 6 apart (at 320 columns) tell counts too, if it is more, which
 * it is not for a Kinect. Not less than the given one, which it is if there are fewer than 100 triples. */
double estimateNoise(const DepthImage& image, double least = 0);
/** \brief The same with memory that is kept from image to image. */
double estimateNoise(const DepthImage& image, double least, std::vector<float>& scratch);

/** \brief Depth to disparity in units of the given inverse-depth noise [1/m]. */
void toDisparity(const DepthImage& image, double unit, DisparityImage& out);

}  // namespace facetloc::internal
