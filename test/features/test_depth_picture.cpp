// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/depth_picture.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace facetloc {
namespace {

using test::Rng, test::uniform;

DepthImage randomImage(Rng& rng, int width, int height, double valid_share) {
  DepthImage image;
  image.camera = {width, height, 100, 105, 0.5 * width, 0.5 * height};
  for (int i = 0; i < width * height; ++i)
    image.depth.push_back(uniform(rng, 0, 1) < valid_share ? static_cast<float>(uniform(rng, 0.4, 9)) : 0.f);
  return image;
}

TEST(DepthPicture, HoldsTheInverseDepthOfEverySecondPixelWithinHalfAQuantum) {
  Rng rng(1);
  for (const int width : {40, 41})
    for (const int height : {30, 31}) {
      const DepthImage image = randomImage(rng, width, height, 0.8);
      const DepthPicture picture = DepthPicture::fromDepth(image);
      ASSERT_EQ(picture.camera, image.camera.subsampled(2));
      for (int v = 0; v < picture.camera.height; ++v)
        for (int u = 0; u < picture.camera.width; ++u) {
          const double z = image.at(2 * u, 2 * v);
          const double stored = DepthPicture::kQuantum *
                                picture.inverse_depth[static_cast<std::size_t>(v) * picture.camera.width + u];
          if (z > 0)
            EXPECT_NEAR(stored, 1 / z, 0.5 * DepthPicture::kQuantum * (1 + 1e-6));
          else
            EXPECT_EQ(stored, 0);
        }
    }
}

TEST(DepthPicture, LowestAndHighestAreThoseOfTheKnownNeighbours) {
  Rng rng(2);
  for (const double valid_share : {0.1, 0.5, 1.0}) {
    const DepthPicture p = DepthPicture::fromDepth(randomImage(rng, 50, 37, valid_share));
    for (int v = 0; v < p.camera.height; ++v)
      for (int u = 0; u < p.camera.width; ++u) {
        int lowest = std::numeric_limits<int>::max(), highest = 0;
        for (int y = std::max(0, v - 1); y <= std::min(p.camera.height - 1, v + 1); ++y)
          for (int x = std::max(0, u - 1); x <= std::min(p.camera.width - 1, u + 1); ++x)
            if (const int d = p.inverse_depth[static_cast<std::size_t>(y) * p.camera.width + x]; d > 0)
              lowest = std::min(lowest, d), highest = std::max(highest, d);
        const std::size_t i = static_cast<std::size_t>(v) * p.camera.width + u;
        EXPECT_EQ(p.extremes[i].highest, highest);
        EXPECT_EQ(p.extremes[i].lowest, highest ? lowest : 0);
      }
  }
}

TEST(DepthPicture, InvalidDepthsAreUnknown) {
  DepthImage image;
  image.camera = {12, 2, 10, 10, 6, 1};
  image.depth.assign(24, 0.f);
  const float inf = std::numeric_limits<float>::infinity();
  // Nothing, not a number, behind the camera, endless, nearer than the 16 bits reach, and the nearest that
  // fits.
  const float z[] = {0.f, std::numeric_limits<float>::quiet_NaN(), -1.f, inf, 0.2f, 0.26f};
  for (int i = 0; i < 6; ++i) image.depth[2 * i] = z[i];
  const DepthPicture p = DepthPicture::fromDepth(image);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(p.inverse_depth[i], 0) << z[i];
  EXPECT_NEAR(p.inverse_depth[5] * DepthPicture::kQuantum, 1 / 0.26, DepthPicture::kQuantum);
}

TEST(DepthPicture, StepsAreFarBelowTheNoiseOfAKinect) {
  EXPECT_LT(DepthPicture::kQuantum * kKinectGain, 0.025);  // disparity units; the noise is 0.5
}

TEST(DepthPicture, StoredValuesComeBackAsTheyWere) {
  Rng rng(3);
  const DepthPicture p = DepthPicture::fromDepth(randomImage(rng, 33, 21, 0.7));
  const DepthPicture again = DepthPicture::fromStored(p.camera, p.inverse_depth);
  EXPECT_EQ(again.camera, p.camera);
  EXPECT_EQ(again.inverse_depth, p.inverse_depth);
  EXPECT_TRUE(again.extremes == p.extremes);
}

TEST(DepthPicture, IsEmptyWithoutDepthAndRefusesTheWrongSize) {
  EXPECT_TRUE(DepthPicture::fromDepth({}).empty());
  const Intrinsics camera{4, 3, 10, 10, 2, 1};
  EXPECT_THROW(DepthPicture::fromStored(camera, std::vector<std::uint16_t>(11)), std::invalid_argument);
  EXPECT_THROW(DepthPicture::fromStored({}, {}), std::invalid_argument);
  EXPECT_NO_THROW(DepthPicture::fromStored(camera, std::vector<std::uint16_t>(12)));
}

}  // namespace
}  // namespace facetloc
