// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/image_noise.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace facetloc {
namespace {

using test::endlessPlane, test::noisy, test::render, test::smallCamera, test::smoothlyNoisy;

DepthImage wallAt(double z) { return render({endlessPlane({0, 0, z}, {0.1, 0.05, 1})}, smallCamera()).image; }

/** Walls from 0.75 m on, every half metre, with this noise. */
std::vector<NoiseSample> samplesOf(const DepthNoise& noise) {
  std::vector<NoiseSample> samples;
  unsigned seed = 1;
  for (double z = 0.75; z < 5; z += 0.5) {
    const auto found = noiseSamples(noisy(wallAt(z), noise.ofInverseDepth(z), seed++));
    samples.insert(samples.end(), found.begin(), found.end());
  }
  return samples;
}

DepthNoise noiseOf(double inverse_depth_std, double depth_std, double slope) {
  DepthNoise noise;
  noise.inverse_depth_std = inverse_depth_std, noise.depth_std = depth_std, noise.depth_std_slope = slope;
  return noise;
}

TEST(NoiseOverRange, IsMeasuredAsItIs) {
  for (const DepthNoise& noise : {DepthNoise(), noiseOf(0.003, 0, 0), noiseOf(1e-7, 0.003, 0),
                                  noiseOf(1e-7, 0.002, 0.002), noiseOf(0.0005, 0.002, 0)}) {
    const auto bins = binned(samplesOf(noise));
    ASSERT_GE(bins.size(), 8u);
    // The noise of a wall is made for its middle; it is not across, so that its ends differ a little.
    for (const NoiseBin& bin : bins)
      EXPECT_NEAR(bin.depthStd() / noise.ofDepth(bin.typical.depth), 1, 0.15) << bin.nearest << " m";
    EXPECT_LT(misfit(noise, bins), 0.12);
    const DepthNoise fitted = fittedNoise(bins);
    for (const double z : {1.0, 2.0, 4.0}) EXPECT_NEAR(fitted.ofDepth(z) / noise.ofDepth(z), 1, 0.15) << z;
  }
}

TEST(NoiseOverRange, OfTriangulationHasOnePart) {
  const DepthNoise fitted = fittedNoise(binned(samplesOf(DepthNoise())));
  EXPECT_TRUE(fitted.isConstantInInverseDepth());
  EXPECT_NEAR(fitted.inverse_depth_std, DepthNoise().inverse_depth_std, 0.1 * DepthNoise().inverse_depth_std);
}

TEST(NoiseOverRange, OfFewDistancesIsAssumedToBeTriangulation) {
  std::vector<NoiseSample> samples = noiseSamples(noisy(wallAt(1.25), 0.002, 1));
  const auto bins = binned(samples);
  ASSERT_EQ(bins.size(), 1u);
  EXPECT_TRUE(fittedNoise(bins).isConstantInInverseDepth());
  EXPECT_NEAR(fittedNoise(bins).inverse_depth_std, 0.002, 2e-4);
}

// The correlation of white noise that was smoothed by a Gaussian of s falls to 1/e over 2 s.
TEST(NoiseOverRange, MeasuresTheCorrelationLength) {
  for (const double smoothing : {1.0, 1.5, 2.0}) {
    const auto bins = binned(noiseSamples(smoothlyNoisy(wallAt(1.25), 0.003, smoothing, 5)));
    ASSERT_EQ(bins.size(), 1u);
    EXPECT_NEAR(correlationLength(bins), 2 * smoothing, 0.3 * 2 * smoothing);
  }
  const auto white = binned(noiseSamples(noisy(wallAt(1.25), 0.003, 5)));
  EXPECT_LT(correlationLength(white), 1);
}

TEST(NoiseOverRange, IsNotThatOfEdgesHolesAndRelief) {
  const std::vector<NoiseSample> clean = noiseSamples(noisy(wallAt(1.25), 0.002, 1));
  ASSERT_GT(clean.size(), 50u);

  DepthImage step = noisy(wallAt(1.25), 0.002, 1);
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; u += 2)
      step.depth[static_cast<std::size_t>(v) * 320 + u] = u % 32 < 8 ? 2.f : 0.f;
  EXPECT_TRUE(noiseSamples(step).empty());

  // Near surfaces that are rough: noise never falls with depth.
  auto samples = noiseSamples(noisy(wallAt(1.25), 0.05, 1));
  const auto farther = noiseSamples(noisy(wallAt(3.25), 0.002, 2));
  samples.insert(samples.end(), farther.begin(), farther.end());
  const auto bins = binned(samples);
  ASSERT_FALSE(bins.empty());
  for (const NoiseBin& bin : bins) EXPECT_GT(bin.nearest, 2) << "only the farther one is left";
}

TEST(NoiseOverRange, OfEmptyImagesIsEmpty) {
  EXPECT_TRUE(noiseSamples({}).empty());
  DepthImage empty = wallAt(2);
  std::fill(empty.depth.begin(), empty.depth.end(), 0.f);
  EXPECT_TRUE(noiseSamples(empty).empty());
  EXPECT_TRUE(binned({}).empty());
  EXPECT_EQ(misfit(DepthNoise(), {}), 0);
  EXPECT_EQ(correlationLength({}), 0);
}

}  // namespace
}  // namespace facetloc
