// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/depth_image.h>

#include <vector>

namespace facetloc {

/** \brief Noise of a depth image, measured from its second differences, rough or smooth over many pixels
 * (segmentation/METHOD 2.2, 2.3); at least the noise of its camera, which an empty image has. */
SensorNoise measuredNoise(const DepthImage& image, const SensorNoise& of_camera);

/** \brief Noise of a small flat part of a depth image. */
struct NoiseSample {
  double depth = 0;              ///< [m]
  double inverse_depth_std = 0;  ///< about its own plane [1/m]
  double correlation_px = 0;     ///< distance at which the correlation of residuals falls to 1/e [px]
};

/** \brief Looks for flat tiles, a tenth of the image wide, and how their inverse depths scatter about their
 * planes (METHOD 2.5). Tiles with holes, edges or outliers are left out. Noise that is smooth over a whole
 * tile is taken for a slope, and not seen. */
std::vector<NoiseSample> noiseSamples(const DepthImage& image);

/** \brief Noise of the samples of one range of depths. */
struct NoiseBin {
  double nearest = 0, farthest = 0;  ///< depths that fall into it [m]
  std::size_t samples = 0;
  NoiseSample typical;  ///< medians of the quieter half; the rest may show uneven surfaces

  double depthStd() const { return typical.inverse_depth_std * typical.depth * typical.depth; }  ///< [m]
};

/** \brief The samples in bins of half a metre. Left out are bins with few samples, and those in which depth
 * is much noisier than farther away, since they show uneven surfaces. */
std::vector<NoiseBin> binned(std::vector<NoiseSample> samples);

/** \brief The noise model that fits the bins best in relative terms, with no more parts than it takes. Three
 * bins tell parts apart; of fewer, all noise counts as constant in inverse depth. Requires one bin. */
DepthNoise fittedNoise(const std::vector<NoiseBin>& bins);

/** \brief How far a model is from the bins: root mean square of the logarithm of their ratio; 0.1 is 10 %. */
double misfit(const DepthNoise& noise, const std::vector<NoiseBin>& bins);

/** \brief Over all bins, weighted by their samples [px]. */
double correlationLength(const std::vector<NoiseBin>& bins);

}  // namespace facetloc
