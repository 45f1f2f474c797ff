// SPDX-License-Identifier: BSD-3-Clause
#include "base/inverse_depth.h"

#include <facetloc/features/depth_image.h>
#include <facetloc/features/depth_picture.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

namespace facetloc::internal {
namespace {

DepthImage counting(int width, int height) {
  DepthImage image;
  image.camera = {width, height, 100, 110, 0.5 * width, 0.5 * height};
  image.depth.resize(static_cast<std::size_t>(width) * height);
  std::iota(image.depth.begin(), image.depth.end(), 1.f);
  return image;
}

TEST(DepthImage, SubsamplingTakesPixelsAndNeverAverages) {
  for (const int step : {1, 2, 3, 7}) {
    const DepthImage full = counting(13, 10), small = subsampled(full, step);
    EXPECT_EQ(small.camera, full.camera.subsampled(step));
    ASSERT_EQ(small.depth.size(), static_cast<std::size_t>(small.camera.width) * small.camera.height);
    for (int v = 0; v < small.camera.height; ++v)
      for (int u = 0; u < small.camera.width; ++u) EXPECT_EQ(small.at(u, v), full.at(step * u, step * v));
  }
}

// Half of the pixels are missing, in one hole or here and there.
TEST(DepthImage, ACameraThatLeavesOutPixelsLosesNoPlanes) {
  DepthImage hole = counting(40, 40), sparse = hole, stripes = hole;
  for (int v = 0; v < 40; ++v)
    for (int u = 0; u < 40; ++u) {
      const int i = v * 40 + u;
      hole.depth[i] = u < 21 ? 0.f : 1000.f + static_cast<float>(i);
      sparse.depth[i] = (3 * u + 7 * v) % 5 < 3 ? std::numeric_limits<float>::quiet_NaN() : hole.depth[i] + 1;
      stripes.depth[i] = u % 2 == 0 ? 0 : static_cast<float>(i);
    }
  const DepthImage of_hole = subsampled(hole, 2), of_sparse = subsampled(sparse, 2),
                   of_stripes = subsampled(stripes, 2);
  for (int v = 0; v < 20; ++v)
    for (int u = 0; u < 20; ++u) {
      EXPECT_EQ(of_hole.at(u, v), hole.at(2 * u, 2 * v)) << "holes stay as large as they are";
      EXPECT_EQ(of_stripes.at(u, v), stripes.at(2 * u + 1, 2 * v));
      float first = sparse.at(2 * u, 2 * v);
      for (const auto& [x, y] : {std::pair(1, 0), {0, 1}, {1, 1}})
        if (!isMeasured(first)) first = sparse.at(2 * u + x, 2 * v + y);
      if (!isMeasured(first)) continue;
      EXPECT_EQ(of_sparse.at(u, v), first) << u << ", " << v;
    }
}

TEST(DepthImage, SubsamplingOfAnEmptyImageIsEmpty) { EXPECT_TRUE(subsampled(DepthImage{}, 2).empty()); }

TEST(DepthImage, SubsamplingOfOneWithoutItsDepthsIsThatOne) {
  DepthImage image;
  image.camera = kinectIntrinsics();
  EXPECT_FALSE(subsampled(image, 2).valid());
  EXPECT_TRUE(subsampled(image, 2).empty());
}

TEST(DepthImage, TheWorkingImageHasAtLeastTheWorkingWidth) {
  const DepthImage image = counting(13, 10);
  EXPECT_EQ(workingImage(image, 6).camera, image.camera.subsampled(2));
  EXPECT_EQ(workingImage(image, 6).depth, subsampled(image, 2).depth);
  for (const int as_it_is : {0, 7, 13, 100, kWorkingWidth})
    EXPECT_EQ(workingImage(image, as_it_is).depth, image.depth) << as_it_is;
}

TEST(DepthImage, TheWorkingWidthIsALowerBound) {
  Intrinsics c = kinectIntrinsics();
  EXPECT_EQ(subsamplingStep(c, 320), 2);
  EXPECT_EQ(subsamplingStep(c, 640), 1);
  EXPECT_EQ(subsamplingStep(c, 1000), 1);
  EXPECT_EQ(subsamplingStep(c, 0), 1);  // full size
  c.width = 959;
  EXPECT_EQ(subsamplingStep(c, 320), 2);
  EXPECT_GE(c.subsampled(2).width, 320);
}

TEST(LabelImage, OfTheWorkingImageGoesToThePixelsOfTheSameDepth) {
  const DepthImage image{{4, 2, 10, 10, 2, 1},
                         {1, 1, 2, 2,  //
                          1, 2, 0, 2}};
  const LabelImage labels{2, 1, {7, 8}}, full = fullLabels(labels, image, 2);
  EXPECT_EQ(full.width, 4);
  EXPECT_EQ(full.height, 2);
  EXPECT_EQ(full.label, (std::vector<std::uint16_t>{7, 7, 8, 8,  //
                                                    7, 8, 0, 8}));
  EXPECT_EQ(fullLabels(full, image, 0).label, full.label);
  EXPECT_THROW(fullLabels(labels, image, 0), std::invalid_argument);
}

TEST(LabelImage, MaxLabelOfAnEmptyImageIsZero) {
  EXPECT_EQ(LabelImage{}.maxLabel(), 0);
  EXPECT_EQ((LabelImage{2, 2, {0, 7, 3, 0}}).maxLabel(), 7);
}

TEST(InvertDepth, IsOneDividedByEachDepthOfAnyNumberOfThem) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> depths = {0, 1, 2.5f, nan, 0.5f, -1, infinity, 1e-4f, 4, 7.5f, 1e-3f, 1e6f, 2e6f};
  for (std::size_t n = 0; n <= depths.size(); ++n) {
    std::vector<float> out(n + 1, -7);
    invertDepth(depths.data(), n, 3, out.data());
    for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(out[i], isMeasured(depths[i]) ? 3 / depths[i] : 0) << i;
    EXPECT_EQ(out[n], -7) << "written beyond the end";
  }
}

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

const Intrinsics kCamera{160, 120, 150, 150, 79.5, 59.5};

float wallAt(int u, int v) {
  return static_cast<float>(1 / (0.5 + 0.001 * u - 0.0005 * v));  // inverse depth is linear in pixels
}

DepthImage image(const std::function<bool(int, int)>& isMeasured,
                 const std::function<float(int, int)>& depth) {
  DepthImage out{kCamera, {}};
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 0; u < kCamera.width; ++u) out.depth.push_back(isMeasured(u, v) ? depth(u, v) : 0.f);
  return out;
}

/** Pixels that an image coarser by a factor leaves in one to which it was aligned. */
std::function<bool(int, int)> gridOf(double factor) {
  const auto hits = [factor](int i) {
    const double k = std::round((i - 0.4) / factor);
    return std::lround(k * factor + 0.4) == i;
  };
  return [hits](int u, int v) { return hits(u) && hits(v); };
}

TEST(HoleGrid, OfDepthAlignedToAFinerImageIsFilled) {
  for (const double factor : {1.5, 1.7, 2.0, 2.25, 3.0}) {
    DepthImage sparse = image(gridOf(factor), wallAt);
    EXPECT_GT(holeGridReach(sparse), 0) << factor;
    fillHoleGrid(sparse);
    for (int v = 4; v < kCamera.height - 4; ++v)
      for (int u = 4; u < kCamera.width - 4; ++u)
        ASSERT_NEAR(sparse.at(u, v), wallAt(u, v), 5e-3) << factor << " at " << u << " " << v;
  }
}

TEST(HoleGrid, DoesNotMixTheDepthsOfTwoSidesOfAnEdge) {
  DepthImage sparse = image(gridOf(2), [](int u, int) { return u < 80 ? 1.f : 2.f; });
  fillHoleGrid(sparse);
  for (const float z : sparse.depth)
    EXPECT_TRUE(z == 0 || std::abs(z - 1) < 1e-6 || std::abs(z - 2) < 1e-6) << z;
}

TEST(HoleGrid, OtherImagesStayAsTheyAre) {
  std::mt19937 engine(3);
  const auto unchanged = [](DepthImage whole) {
    const DepthImage before = whole;
    EXPECT_EQ(holeGridReach(whole), 0);
    fillHoleGrid(whole);
    EXPECT_EQ(whole.depth, before.depth);
  };
  unchanged(image([](int, int) { return true; }, wallAt));
  unchanged(image([](int u, int) { return u > 100; }, wallAt));                       // half of it is empty
  unchanged(image([&](int, int) { return engine() % 5 != 0; }, wallAt));              // speckles
  unchanged(image([](int u, int v) { return (u / 12 + v / 12) % 2 == 0; }, wallAt));  // large holes
  unchanged(image([](int, int) { return false; }, wallAt));
  unchanged(DepthImage());
}

TEST(HoleGrid, LargerHolesStay) {
  const auto grid = gridOf(2);
  DepthImage sparse =
      image([&](int u, int v) { return grid(u, v) && !(u > 60 && u < 90 && v > 40 && v < 70); }, wallAt);
  fillHoleGrid(sparse);
  EXPECT_EQ(sparse.at(75, 55), 0);
  EXPECT_GT(sparse.at(30, 30), 0);
}

}  // namespace
}  // namespace facetloc::internal
