// SPDX-License-Identifier: BSD-3-Clause
#include "smooth_noise.h"

#include "disparity_image.h"

#include <algorithm>
#include <cmath>

namespace facetloc::internal {
namespace {

constexpr int kRows = 60, kFewRows = 20;
constexpr double kApart = 6;  // [px at 320 columns] most triples of a room lie in one surface
constexpr double kSmooth =
    3;                       // times the noise of neighbours; a Kinect has 1.5 to 2.9, a stereo camera 3 to 7
constexpr double kTrim = 3;  // larger differences are edges [noise of pixels farther apart]

/** Noise of neighbours, as if it was white. Depths that come in steps have many differences of zero and some
 * of a step: their median says nothing, their mean square does. */
double noiseOfNeighbours(const DepthImage& image, double limit, std::vector<float>& scratch) {
  const Differences found = secondDifferences(image, 1, kRows, scratch);
  double squares = 0, n = 0;
  for (const float* x = found.begin; x != found.end; ++x) {
    const double square = static_cast<double>(*x) * *x / 6;
    if (square > limit * limit) continue;
    squares += square;
    n += 1;
  }
  return n > 0 ? std::sqrt(squares / n) : 0;
}

/** Variance of a second difference over pixels so far apart, of unit noise of this correlation length. */
double differenceVariance(double apart, double correlation) {
  const double square = std::pow(apart / correlation, 2);
  return 6 - 8 * std::exp(-square) + 2 * std::exp(-4 * square);
}

/** The correlation length at which differences over half the distance have this share of the variance. */
double correlationLength(double share, double apart) {
  // Longer ones than this look like surfaces that are not flat.
  double shortest = 0.1 * apart, longest = std::sqrt(2.0) * apart;
  for (int i = 0; i < 40; ++i) {
    const double middle = (shortest + longest) / 2;
    const bool too_short = differenceVariance(apart / 2, middle) > share * differenceVariance(apart, middle);
    (too_short ? shortest : longest) = middle;
  }
  return longest;
}

}  // namespace

std::optional<SmoothNoise> estimateSmoothNoise(const DepthImage& image, std::vector<float>& scratch) {
  if (!image.valid()) return {};
  const int half = static_cast<int>(std::lround(kApart / 2 * std::sqrt(scaledPixels(1, image.camera))));
  if (half < 2) return {};  // neighbours are all there is
  const double far = noiseByDifferences(image, 2 * half, kFewRows, scratch);
  if (!(far > kSmooth * noiseOfNeighbours(image, kTrim * far, scratch))) return {};
  const double near = noiseByDifferences(image, half, kFewRows, scratch);
  const double length = correlationLength(std::pow(near / far, 2), 2.0 * half);
  return SmoothNoise{far / std::sqrt(differenceVariance(2.0 * half, length) / 6), length};
}

}  // namespace facetloc::internal
