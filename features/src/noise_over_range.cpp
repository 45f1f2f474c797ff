// SPDX-License-Identifier: BSD-3-Clause
#include "base/inverse_depth.h"
#include "base/median.h"

#include <facetloc/features/image_noise.h>
#include <facetloc/features/plane_fit.h>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace facetloc {

using namespace internal;
namespace {

constexpr int kTilesAcross = 10, kSmallestTile = 16;  // [px]
constexpr double kMeasured = 0.9;                     // share of a tile's pixels
constexpr double kMadToStd = 1.4826;
constexpr double kTrim = 3.5;           // residuals beyond are no noise [standard deviations]
constexpr double kMostOutliers = 0.02;  // share of the measured pixels
constexpr double kBinWidth = 0.5;       // [m]
constexpr std::size_t kFewest = 20;     // samples of a bin

/** A square of inverse depths of an image, and their residuals from a plane; 0 = not measured. */
class Tile {
public:
  Tile(const std::vector<float>& inverse, int image_width, int u0, int v0, int size)
      : size_(size), inverse_(static_cast<std::size_t>(size) * size), residual_(inverse_.size()) {
    for (int v = 0; v < size; ++v)
      std::copy_n(inverse.begin() + (static_cast<std::ptrdiff_t>(v0 + v) * image_width + u0), size,
                  inverse_.begin() + static_cast<std::ptrdiff_t>(v) * size);
  }

  /** None unless it is flat. */
  std::optional<NoiseSample> sample() {
    const auto measured =
        static_cast<double>(std::count_if(inverse_.begin(), inverse_.end(), [](float d) { return d > 0; }));
    if (measured < kMeasured * static_cast<double>(inverse_.size())) return {};
    double limit = std::numeric_limits<double>::infinity();
    double kept = 0;
    for (int pass = 0; pass < 3; ++pass) {
      kept = fit(limit);
      limit = kTrim * kMadToStd * medianResidual();
      if (!(limit > 0)) return {};  // a measured plane is never exact: values are too coarse
    }
    const double outliers = static_cast<double>(
        std::count_if(residual_.begin(), residual_.end(), [&](float r) { return std::abs(r) > limit; }));
    if (outliers > kMostOutliers * measured || !(kept > 0)) return {};
    const double variance = covariance(0, 0, limit);
    NoiseSample sample;
    sample.depth = 1 / mean_;
    sample.inverse_depth_std = std::sqrt(variance * kept / std::max(1.0, kept - 3));
    sample.correlation_px = correlationLength(variance, limit);
    if (!(sample.inverse_depth_std > 0)) return {};
    return sample;
  }

private:
  bool has(std::size_t i) const { return inverse_[i] > 0; }
  int column(std::size_t i) const { return static_cast<int>(i) % size_; }
  int row(std::size_t i) const { return static_cast<int>(i) / size_; }

  /** The plane of the pixels whose residuals so far are within the limit; sets the residuals of all.
   * \return the number of pixels that were used. */
  double fit(double limit) {
    PlaneMoments moments;
    for (std::size_t i = 0; i < inverse_.size(); ++i)
      if (has(i) && std::abs(residual_[i]) <= limit) moments.add(column(i), row(i), inverse_[i]);
    const PixelPlane plane = moments.fit().plane;
    mean_ = moments.d / moments.n;
    for (std::size_t i = 0; i < inverse_.size(); ++i)
      residual_[i] = has(i) ? static_cast<float>(inverse_[i] - plane.at(column(i), row(i))) : 0;
    return moments.n;
  }

  double medianResidual() {
    scratch_.clear();
    for (std::size_t i = 0; i < residual_.size(); ++i)
      if (has(i)) scratch_.push_back(std::abs(residual_[i]));
    return internal::median(scratch_.begin(), scratch_.end());
  }

  /** Mean product of residuals that are so far apart. */
  double covariance(int du, int dv, double limit) const {
    double sum = 0, n = 0;
    for (int v = 0; v + dv < size_; ++v)
      for (int u = 0; u + du < size_; ++u) {
        const std::size_t i = static_cast<std::size_t>(v) * size_ + u;
        const std::size_t j = static_cast<std::size_t>(v + dv) * size_ + u + du;
        const double a = residual_[i], b = residual_[j];
        if (!has(i) || !has(j) || std::abs(a) > limit || std::abs(b) > limit) continue;
        sum += a * b;
        n += 1;
      }
    return n > 0 ? sum / n : 0;
  }

  /** Where the correlation, along rows and columns, first falls below 1/e; between pixels, linear. */
  double correlationLength(double variance, double limit) const {
    const double threshold = std::exp(-1.0);
    double before = 1;
    for (int lag = 1; lag <= size_ / 2; ++lag) {
      const double now = (covariance(lag, 0, limit) + covariance(0, lag, limit)) / (2 * variance);
      if (now < threshold) return lag - 1 + (before - threshold) / (before - now);
      before = now;
    }
    return size_ / 2.0;
  }

  int size_;
  std::vector<float> inverse_, residual_, scratch_;
  double mean_ = 0;
};

/** Medians of the quieter half: tiles that are not quite flat make the other. */
NoiseSample typicalOf(std::vector<NoiseSample> samples) {
  std::sort(samples.begin(), samples.end(), [](const NoiseSample& a, const NoiseSample& b) {
    return a.inverse_depth_std < b.inverse_depth_std;
  });
  samples.resize((samples.size() + 1) / 2);
  const auto median = [&](double NoiseSample::*value) {
    std::vector<double> values;
    std::transform(samples.begin(), samples.end(), std::back_inserter(values),
                   [&](const NoiseSample& s) { return s.*value; });
    return internal::median(values.begin(), values.end());
  };
  return {median(&NoiseSample::depth), median(&NoiseSample::inverse_depth_std),
          median(&NoiseSample::correlation_px)};
}

/** Noise of depth does not fall with depth: where it seems to, the nearer tiles show uneven surfaces. */
void dropRelief(std::vector<NoiseBin>& bins) {
  constexpr double kMuch = 1.5;  // factor on the noise farther away
  double least_behind = std::numeric_limits<double>::infinity();
  for (auto bin = bins.rbegin(); bin != bins.rend(); ++bin) {
    if (bin->depthStd() > kMuch * least_behind) bin->samples = 0;
    least_behind = std::min(least_behind, bin->depthStd());
  }
  bins.erase(std::remove_if(bins.begin(), bins.end(), [](const NoiseBin& b) { return b.samples == 0; }),
             bins.end());
}

/** Least squares of sum of parts / measured - 1 over the bins, for some of the three parts.
 * \return the sum of squares; infinite where a part would be negative. */
double fitParts(const std::vector<NoiseBin>& bins, const std::array<bool, 3>& used, DepthNoise& noise) {
  const auto rows = static_cast<Eigen::Index>(bins.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(rows, 3);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const NoiseBin& bin = bins[static_cast<std::size_t>(i)];
    const double z = bin.typical.depth, std = bin.depthStd();
    const std::array<double, 3> parts = {1 / std, z / std, z * z / std};
    for (std::size_t k = 0; k < 3; ++k)
      if (used[k]) A(i, static_cast<Eigen::Index>(k)) = parts[k];
  }
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(rows);
  const Eigen::Vector3d x = A.completeOrthogonalDecomposition().solve(ones);  // 0 for unused terms
  if (x.minCoeff() < -1e-12) return std::numeric_limits<double>::infinity();
  noise.depth_std = std::max(0.0, x[0]);
  noise.depth_std_slope = std::max(0.0, x[1]);
  noise.inverse_depth_std = std::max(DepthNoise::kLeastInverseDepthStd, x[2]);
  return (A * x - ones).squaredNorm();
}

}  // namespace

std::vector<NoiseSample> noiseSamples(const DepthImage& image) {
  std::vector<NoiseSample> samples;
  if (!image.valid()) return samples;
  const int width = image.camera.width, height = image.camera.height;
  const int size = std::max(kSmallestTile, width / kTilesAcross);
  std::vector<float> inverse(image.depth.size());
  invertDepth(image.depth.data(), image.depth.size(), 1.f, inverse.data());
  for (int v = 0; v + size <= height; v += size)
    for (int u = 0; u + size <= width; u += size)
      if (const auto sample = Tile(inverse, width, u, v, size).sample()) samples.push_back(*sample);
  return samples;
}

std::vector<NoiseBin> binned(std::vector<NoiseSample> samples) {
  std::sort(samples.begin(), samples.end(),
            [](const NoiseSample& a, const NoiseSample& b) { return a.depth < b.depth; });
  const auto binOf = [](const NoiseSample& s) { return std::floor(s.depth / kBinWidth); };
  std::vector<NoiseBin> bins;
  for (auto first = samples.begin(); first != samples.end();) {
    const double bin = binOf(*first);
    const auto end =
        std::find_if(first, samples.end(), [&](const NoiseSample& s) { return binOf(s) != bin; });
    if (const auto n = static_cast<std::size_t>(end - first); n >= kFewest) {
      NoiseBin found{bin * kBinWidth, (bin + 1) * kBinWidth, n, {}};
      found.typical = typicalOf({first, end});
      bins.push_back(found);
    }
    first = end;
  }
  dropRelief(bins);
  return bins;
}

DepthNoise fittedNoise(const std::vector<NoiseBin>& bins) {
  constexpr std::size_t kToTellParts = 3;
  constexpr double kWorthAPart = 0.75;  // largest share of the squared error that a useful term leaves
  constexpr double kExact = 1e-6;       // per bin: nothing is left to explain
  DepthNoise best;
  double least = fitParts(bins, {false, false, true}, best);
  if (bins.size() < kToTellParts) return best;
  // Fewer terms first, and z^2 first among them, the term of most cameras.
  constexpr std::array<std::array<bool, 3>, 6> kOthers = {{{true, false, false},
                                                           {false, true, false},
                                                           {true, false, true},
                                                           {false, true, true},
                                                           {true, true, false},
                                                           {true, true, true}}};
  for (const auto& used : kOthers) {
    DepthNoise noise;
    const double squares = fitParts(bins, used, noise);
    if (least < kExact * static_cast<double>(bins.size()) || !(squares < kWorthAPart * least)) continue;
    least = squares, best = noise;
  }
  return best;
}

double misfit(const DepthNoise& noise, const std::vector<NoiseBin>& bins) {
  double squares = 0;
  for (const NoiseBin& bin : bins)
    squares += std::pow(std::log(noise.ofDepth(bin.typical.depth) / bin.depthStd()), 2);
  return bins.empty() ? 0 : std::sqrt(squares / static_cast<double>(bins.size()));
}

double correlationLength(const std::vector<NoiseBin>& bins) {
  double sum = 0, n = 0;
  for (const NoiseBin& bin : bins) {
    sum += static_cast<double>(bin.samples) * bin.typical.correlation_px;
    n += static_cast<double>(bin.samples);
  }
  return n > 0 ? sum / n : 0;
}

}  // namespace facetloc
