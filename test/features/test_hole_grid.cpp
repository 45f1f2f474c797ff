// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/depth_image.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace facetloc {
namespace {

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
}  // namespace facetloc
