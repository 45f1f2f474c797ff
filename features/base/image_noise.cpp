// SPDX-License-Identifier: BSD-3-Clause
#include "base/image_noise.h"

#include "base/inverse_depth.h"
#include "base/lanes.h"

#include <facetloc/features/image_noise.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace facetloc {
namespace internal {
namespace {

// The median of n floats that are not negative, the upper of two; moves them about. Counting by exponent and
// first digits leaves a few percent of them to sort.
float median(float* x, std::size_t n) {
  constexpr int kUnsorted = 20;  // bits
  std::array<std::uint32_t, 1u << (32 - kUnsorted)> count{};
  for (std::size_t i = 0; i < n; ++i) ++count[bitsOf(x[i]) >> kUnsorted];
  std::size_t bin = 0, rank = n / 2;
  for (; rank >= count[bin]; ++bin) rank -= count[bin];
  float* const end = std::partition(x, x + n, [&](float y) { return bitsOf(y) >> kUnsorted == bin; });
  std::nth_element(x, x + rank, end);
  return x[rank];
}

constexpr int kRows = 60, kFewRows = 20;  // give the median to a percent; tell smooth noise well enough
constexpr double kApart = 6;              // [px at 320 columns] most triples of a room lie in one surface
constexpr double kSmooth =
    3;                       // times the noise of neighbours; a Kinect has 1.5 to 2.9, a stereo camera 3 to 7
constexpr double kTrim = 3;  // larger differences are edges [noise of pixels farther apart]

/** Absolute second differences of inverse depth, in memory of their caller [1/m]. */
struct Differences {
  float *begin, *end;
  std::size_t size() const { return static_cast<std::size_t>(end - begin); }
};

/** |x(u - apart) - 2 x(u) + x(u + apart)| wherever all three are measured, in about the given number of rows.
 */
Differences secondDifferences(const DepthImage& image, int apart, int rows, std::vector<float>& scratch) {
  const int w = image.camera.width, step = std::max(1, image.camera.height / rows);
  scratch.resize(w + static_cast<std::size_t>(w) * (image.camera.height / step + 1));
  float* const row = scratch.data();  // first the inverse depths, then the differences
  float* const differences = row + w;
  float* next = differences;
  for (int v = step / 2; v < image.camera.height; v += step) {
    invertDepth(image.depth.data() + static_cast<std::size_t>(v) * w, w, 1.f, row);
    for (int u = apart; u + apart < w; ++u) {
      *next = std::abs(row[u - apart] - 2 * row[u] + row[u + apart]);
      next += row[u - apart] > 0 && row[u] > 0 && row[u + apart] > 0;
    }
  }
  return {differences, next};
}

/** Noise of inverse depth by the median of such differences, as if it was white [1/m]; 0 if they are few. */
double noiseByDifferences(const DepthImage& image, int apart, int rows, std::vector<float>& scratch) {
  constexpr double kMadToStd = 1.4826;
  const double scale =
      kMadToStd / std::sqrt(6.0);  // the variance of d0 - 2 d1 + d2 is 6 for unit white noise
  const Differences found = secondDifferences(image, apart, rows, scratch);
  constexpr std::size_t kFew = 100;
  return found.size() < kFew ? 0 : scale * median(found.begin, found.size());
}

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

double estimateNoise(const DepthImage& image, double least) {
  std::vector<float> scratch;
  return estimateNoise(image, least, scratch);
}

double estimateNoise(const DepthImage& image, double least, std::vector<float>& scratch) {
  constexpr double kOfSmooth = 0.5;  // tolerances of several standard deviations bear the rest
  if (!image.valid()) return least;
  const int apart = static_cast<int>(std::lround(kApart * std::sqrt(scaledPixels(1, image.camera))));
  return std::max({least, noiseByDifferences(image, 1, kRows, scratch),
                   kOfSmooth * noiseByDifferences(image, std::max(1, apart), kFewRows, scratch)});
}

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

void measureNoise(const DepthImage& image, double& noise, double& correlation_px,
                  std::vector<float>& scratch) {
  noise = estimateNoise(image, noise, scratch);
  constexpr double kMuch = 0.5;  // share of the noise: less may as well be roughness
  const auto smooth = estimateSmoothNoise(image, scratch);
  if (!smooth || smooth->std < kMuch * noise) return;
  noise = std::max(noise, smooth->std);
  correlation_px =
      std::max(correlation_px, smooth->correlation_px / std::sqrt(scaledPixels(1, image.camera)));
}

}  // namespace internal

SensorNoise measuredNoise(const DepthImage& image, const SensorNoise& of_camera) {
  const double depth = usualDepth(image);
  double inverse_std = std::max(SensorNoise::kLeastInverseDepthStd, of_camera.ofInverseDepth(depth));
  SensorNoise noise = of_camera;
  std::vector<float> scratch;
  internal::measureNoise(image, inverse_std, noise.correlation_px, scratch);
  static_cast<DepthNoise&>(noise) = of_camera.scaledTo(inverse_std, depth);
  return noise;
}

}  // namespace facetloc
