// SPDX-License-Identifier: BSD-3-Clause
#include "base/inverse_depth.h"

#include <facetloc/features/depth_image.h>

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace facetloc {

using namespace internal;
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

}  // namespace
}  // namespace facetloc
