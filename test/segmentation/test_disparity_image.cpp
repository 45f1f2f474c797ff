// SPDX-License-Identifier: BSD-3-Clause
#include "base/image_noise.h"
#include "disparity_image.h"

#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace facetloc {
namespace {

using namespace internal;
using test::endlessPlane, test::noisy, test::render, test::smallCamera;

DepthImage wall() { return render({endlessPlane({0, 0, 2}, {0.3, 0.2, 1})}, smallCamera()).image; }

// Noise by the differences of neighbours alone, in every step-th row.
double noiseOfNeighbours(const DepthImage& image, int step) {
  std::vector<double> differences;
  for (int v = step / 2; v < image.camera.height; v += step)
    for (int u = 1; u + 1 < image.camera.width; ++u) {
      const double a = image.at(u - 1, v), b = image.at(u, v), c = image.at(u + 1, v);
      if (isMeasured(a) && isMeasured(b) && isMeasured(c))
        differences.push_back(std::abs(1 / a - 2 / b + 1 / c));
    }
  std::sort(differences.begin(), differences.end());
  return 1.4826 * differences[differences.size() / 2] / std::sqrt(6.0);
}

TEST(DisparityImage, IsInverseDepthInItsUnit) {
  DepthImage image = wall();
  image.depth[0] = 0;
  image.depth[1] = std::numeric_limits<float>::quiet_NaN();
  image.depth[2] = -1;
  image.depth[3] = std::numeric_limits<float>::infinity();
  DisparityImage d;
  toDisparity(image, 0.0014, d);
  EXPECT_EQ(d.camera, image.camera);
  EXPECT_EQ(d.unit, 0.0014);
  ASSERT_EQ(d.d.size(), image.depth.size());
  for (int i = 0; i < 4; ++i) EXPECT_EQ(d.d[i], 0.f) << i;
  for (std::size_t i = 4; i < d.d.size(); ++i) {
    EXPECT_GT(d.d[i], 0.f);
    EXPECT_NEAR(d.d[i] * d.unit * image.depth[i], 1, 1e-6);
  }
}

TEST(DisparityImage, ReplacesItsFormerContent) {
  DisparityImage d;
  toDisparity(wall(), 1, d);
  toDisparity({}, 1, d);
  EXPECT_TRUE(d.d.empty());
}

TEST(EstimateNoise, IsThatOfWhiteNoiseWithinATenth) {
  for (const double sigma : {0.2, 0.5, 1.5, 5.0})
    for (unsigned seed = 0; seed < 5; ++seed)
      EXPECT_NEAR(estimateNoise(noisy(wall(), sigma / kKinectGain, seed)) * kKinectGain, sigma, 0.1 * sigma);
}

// Neighbours at a distance d are correlated by exp(-d^2 / 4 s^2) if s is the smoothing.
TEST(EstimateNoise, OfSmoothNoiseIsHalfTheNoiseOfPixelsApart) {
  constexpr double kStd = 0.006, kApart = 6;
  const auto correlated = [](double distance, double smoothing) {
    return std::exp(-distance * distance / (4 * smoothing * smoothing));
  };
  for (const int finer : {1, 2}) {
    Intrinsics camera = smallCamera();
    camera.width *= finer, camera.height *= finer, camera.fx *= finer, camera.fy *= finer;
    camera.cx *= finer, camera.cy *= finer;
    const DepthImage image = render({endlessPlane({0, 0, 2}, {0.3, 0.2, 1})}, camera).image;
    for (const double smoothing : {1.0, 2.0, 3.0})
      for (unsigned seed = 0; seed < 3; ++seed) {
        const double variance = 6 - 8 * correlated(kApart, smoothing) + 2 * correlated(2 * kApart, smoothing);
        const double expected = 0.5 * kStd * std::sqrt(variance / 6);
        const DepthImage smooth = test::smoothlyNoisy(image, kStd, smoothing * finer, seed);
        EXPECT_NEAR(estimateNoise(smooth, SensorNoise{}.inverse_depth_std), expected, 0.1 * expected)
            << smoothing << " px at " << camera.width;
      }
  }
}

// The rounding of a Kinect, and edges and holes, are not taken for smooth noise.
TEST(EstimateNoise, OfAKinectComesFromNeighbours) {
  for (const double sigma : {0.1, 0.3, 0.5, 0.7}) {
    DepthImage image =
        render(test::furnishedRoom(), smallCamera(), test::lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2})).image;
    image = test::rounded(noisy(image, sigma / kKinectGain, 1));
    const double least = SensorNoise{}.inverse_depth_std;
    constexpr int kRowsLookedAt = 4;  // one row in this number
    EXPECT_NEAR(estimateNoise(image, least), std::max(least, noiseOfNeighbours(image, kRowsLookedAt)),
                1e-5 * least)
        << sigma;
  }
}

TEST(EstimateNoise, IsNotLessThanTheGivenOne) {
  EXPECT_EQ(estimateNoise({}, 0.002), 0.002);
  EXPECT_EQ(estimateNoise(wall(), 0.002), 0.002);
  EXPECT_EQ(estimateNoise(noisy(wall(), 0.001, 1), 0.002), 0.002);
  EXPECT_GT(estimateNoise(noisy(wall(), 0.003, 1), 0.002), 0.0027);
}

// At 60 rows and less, the differences of all rows count.
TEST(EstimateNoise, IsTheMedianOfAllSecondDifferencesOfASmallImage) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    DepthImage image;
    image.camera = smallCamera();
    image.camera.width = 20 + static_cast<int>(seed), image.camera.height = 60;
    test::Rng rng(seed);
    for (int i = 0; i < image.camera.width * image.camera.height; ++i)
      image.depth.push_back(
          static_cast<float>(test::uniform(rng, -1, 6)));  // a seventh of them is not measured
    const double of_neighbours = noiseOfNeighbours(image, 1);
    EXPECT_NEAR(estimateNoise(image), of_neighbours, 1e-6 * of_neighbours);
  }
}

TEST(EstimateNoise, DoesNotMindEdgesAndHoles) {
  DepthImage image =
      render(test::furnishedRoom(), smallCamera(), test::lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2})).image;
  image = noisy(image, 0.5 / kKinectGain, 1);
  test::Rng rng(2);
  for (float& z : image.depth)
    if (test::uniform(rng, 0, 1) < 0.2) z = 0;
  EXPECT_NEAR(estimateNoise(image) * kKinectGain, 0.5, 0.05);
}

TEST(EstimateNoise, OfTooFewPixelsIsUnknown) {
  EXPECT_EQ(estimateNoise({}), 0);
  constexpr int kLookedAt = 2;  // this row of every four
  const DepthImage whole = noisy(wall(), SensorNoise{}.inverse_depth_std, 1);
  DepthImage image = whole;
  const auto keep = [&](int pixels) {  // which make two triples of neighbours less
    std::fill(image.depth.begin(), image.depth.end(), 0.f);
    const auto row = static_cast<std::ptrdiff_t>(kLookedAt) * whole.camera.width;
    std::copy_n(whole.depth.begin() + row, pixels, image.depth.begin() + row);
  };
  keep(101);
  EXPECT_EQ(estimateNoise(image), 0);
  keep(102);
  EXPECT_GT(estimateNoise(image), 0);
  std::fill(image.depth.begin(), image.depth.end(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(estimateNoise(image), 0);
}

TEST(EstimateNoise, OfAnImageWithoutItsDepthsIsUnknown) {
  DepthImage image = wall();
  image.depth.clear();
  EXPECT_EQ(estimateNoise(image), 0);
}

TEST(EstimateNoise, OfAnExactPlaneIsNextToNothing) { EXPECT_LT(estimateNoise(wall()) * kKinectGain, 1e-3); }

}  // namespace
}  // namespace facetloc
