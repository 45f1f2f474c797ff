// SPDX-License-Identifier: BSD-3-Clause
#include "cell_moments.h"

#include <facetloc/testing/disparity_images.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

using namespace internal;
using test::blankDisparity, test::randomDisparity, test::Rng, test::roomDisparity, test::uniform;

constexpr float kAnything = std::numeric_limits<float>::infinity();

std::vector<Cell> cellsOf(const DisparityImage& image, const CellBounds& bounds) {
  const int columns = (image.camera.width + kSmallestCell - 1) / kSmallestCell;
  const int rows = (image.camera.height + kSmallestCell - 1) / kSmallestCell;
  std::vector<Cell> cells(static_cast<std::size_t>(columns) * rows);
  for (int row = 0; row < rows; ++row)
    fitSmallestCells(image, row, bounds, &cells[std::size_t(row) * columns]);
  return cells;
}

// The measured pixels of a cell, one by one.
std::vector<Eigen::Vector3d> pixelsOf(const DisparityImage& image, std::size_t cell) {
  const int w = image.camera.width, columns = (w + kSmallestCell - 1) / kSmallestCell;
  const int left = static_cast<int>(cell) % columns * kSmallestCell;
  const int top = static_cast<int>(cell) / columns * kSmallestCell;
  std::vector<Eigen::Vector3d> pixels;
  for (int v = top; v < std::min(top + kSmallestCell, image.camera.height); ++v)
    for (int u = left; u < std::min(left + kSmallestCell, w); ++u)
      if (const float d = image.d[static_cast<std::size_t>(v) * w + u]; d > 0) pixels.emplace_back(u, v, d);
  return pixels;
}

// Images of sizes that are no multiples of a cell, with holes and without.
std::vector<DisparityImage> images() {
  std::vector<DisparityImage> out = {roomDisparity(test::tinyCamera(), 1)};
  unsigned seed = 2;
  for (const auto& [width, height] : {std::pair{32, 16}, {29, 14}, {31, 13}, {7, 5}, {3, 2}, {1, 1}}) {
    Rng rng(++seed);
    for (const double share : {1.0, 0.95, 0.6}) {
      DisparityImage image = blankDisparity(width, height);  // steps whose sums are exact
      for (float& d : image.d)
        if (uniform(rng, 0, 1) < share)
          d = static_cast<float>(std::round(uniform(rng, 400, 420) * 1024) / 1024);
      out.push_back(image);
    }
  }
  return out;
}

TEST(CellMoments, AreTheSumsOverTheMeasuredPixels) {
  for (const DisparityImage& image : images()) {
    const std::vector<Cell> cells = cellsOf(image, {0, kAnything});
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::vector<Eigen::Vector3d> pixels = pixelsOf(image, i);
      ASSERT_EQ(cells[i].flat, !pixels.empty());
      if (pixels.empty()) continue;
      PlaneMoments sum;
      for (const Eigen::Vector3d& p : pixels) sum.add(p.x(), p.y(), p.z());
      const PlaneMoments& m = cells[i].moments;
      EXPECT_EQ(m.n, sum.n);
      EXPECT_EQ(m.u, sum.u);
      EXPECT_EQ(m.v, sum.v);
      EXPECT_EQ(m.d, sum.d);
      EXPECT_EQ(m.uu, sum.uu);
      EXPECT_EQ(m.uv, sum.uv);
      EXPECT_EQ(m.vv, sum.vv);
      EXPECT_EQ(m.ud, sum.ud);
      EXPECT_EQ(m.vd, sum.vd);
      EXPECT_NEAR(m.dd, sum.dd, 1e-8 * sum.dd);
    }
  }
}

TEST(CellMoments, SquaredResidualsAreThoseOfLeastSquares) {
  int checked = 0;
  for (const DisparityImage& image : images()) {
    const std::vector<Cell> cells = cellsOf(image, {0, kAnything});
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::vector<Eigen::Vector3d> pixels = pixelsOf(image, i);
      if (pixels.size() < 12) continue;  // fewer may lie on a line
      const double sse = test::squaredResiduals(pixels);
      EXPECT_NEAR(cells[i].sse, sse, 1e-4 * (1 + sse));
      ++checked;
    }
  }
  EXPECT_GT(checked, 300);
}

TEST(CellMoments, ACellIsFlatUpToItsMeanSquare) {
  const DisparityImage image = randomDisparity(64, 48, 1, 9);
  const float between = 4e4f;  // some have more, some less
  const std::vector<Cell> all = cellsOf(image, {0, kAnything}), some = cellsOf(image, {0, between});
  int flat = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(some[i].flat, all[i].sse <= 16 * between);
    flat += some[i].flat;
  }
  EXPECT_GT(flat, 0);
  EXPECT_LT(flat, static_cast<int>(all.size()));
}

TEST(CellMoments, APoorlyFilledCellIsNotFlat) {
  DisparityImage image = blankDisparity(8, 8);
  std::fill_n(image.d.begin(), 8, 100.f);              // a row of two cells: a quarter
  std::fill_n(image.d.begin() + 4 * 8, 4 * 8, 100.f);  // all of the two below
  const std::vector<Cell> cells = cellsOf(image, {0.5, 1.f});
  EXPECT_FALSE(cells[0].flat);
  EXPECT_FALSE(cells[1].flat);
  EXPECT_TRUE(cells[2].flat);
  EXPECT_TRUE(cells[3].flat);
  EXPECT_TRUE(cellsOf(image, {0.25, 1.f})[0].flat);
}

// A steep plane far away, for which disparities themselves in single precision would not do.
TEST(CellMoments, AnExactPlaneHasNoResidual) {
  DisparityImage image = blankDisparity(64, 48);
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) image.d[static_cast<std::size_t>(v) * 64 + u] = 4000.f + 8.f * u - 5.5f * v;
  for (const Cell& cell : cellsOf(image, {0.5, 1.f})) {
    EXPECT_TRUE(cell.flat);
    EXPECT_LT(cell.sse, 1e-2);
  }
}

}  // namespace
}  // namespace facetloc
