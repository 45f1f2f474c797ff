// SPDX-License-Identifier: BSD-3-Clause
#include "cell_moments.h"
#include "edge_queue.h"
#include "triangle_rows.h"

#include <facetloc/testing/disparity_images.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

namespace facetloc::internal {
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

using namespace internal;
using Edge = EdgeQueue::Edge;

struct Order {
  bool operator()(const Edge& x, const Edge& y) const {
    return std::tie(x.cost, x.a, x.b) < std::tie(y.cost, y.a, y.b);
  }
};

bool always(const Edge&) { return true; }

// Against a sorted set, with pushes below and above the last cost taken, ties, and edges that go out of date.
TEST(EdgeQueue, GivesTheCheapestCurrentEdgeAsASortedSetDoes) {
  constexpr float kMaxCost = 2.75f;
  std::mt19937 random(1);
  const auto below = [&random](int n) { return static_cast<int>(random() % n); };
  EdgeQueue queue;
  for (int repetition = 0; repetition < 20; ++repetition) {  // with the same object
    queue.clear(kMaxCost);
    std::set<Edge, Order> expected;
    std::vector<std::uint32_t> version(50, 0);
    const auto is_current = [&version](const Edge& e) {
      return version[e.a] == e.version_a && version[e.b] == e.version_b;
    };
    for (int step = 0; step < 2000; ++step) {
      if (below(3) > 0) {
        const int a = below(50), b = below(50);
        const Edge e{kMaxCost * static_cast<float>(below(400)) / 399.f, a, b, version[a], version[b]};
        if (expected.insert(e).second) queue.push(e);
      } else if (below(4) == 0) {
        const int changed = below(50);
        ++version[changed];
        for (auto e = expected.begin(); e != expected.end();)
          e = e->a == changed || e->b == changed ? expected.erase(e) : std::next(e);
      } else {
        Edge cheapest;
        const bool found = queue.pop(cheapest, is_current);
        ASSERT_EQ(found, !expected.empty());
        if (!found) continue;
        EXPECT_FALSE(Order()(cheapest, *expected.begin()) || Order()(*expected.begin(), cheapest));
        expected.erase(expected.begin());
      }
    }
    Edge cheapest;
    for (const Edge& e : expected) {
      ASSERT_TRUE(queue.pop(cheapest, is_current));
      EXPECT_FALSE(Order()(cheapest, e) || Order()(e, cheapest));
    }
    EXPECT_FALSE(queue.pop(cheapest, is_current));
  }
}

TEST(EdgeQueue, TakesTheLargestCostAndCostsOfZero) {
  EdgeQueue queue;
  queue.clear(2.75);
  queue.push({2.75f, 1, 2, 0, 0});
  queue.push({0.f, 3, 4, 0, 0});
  Edge e;
  ASSERT_TRUE(queue.pop(e, always));
  EXPECT_EQ(e.a, 3);
  ASSERT_TRUE(queue.pop(e, always));
  EXPECT_EQ(e.a, 1);
  EXPECT_FALSE(queue.pop(e, always));
}

// ceil(n / d), d > 0.
std::int64_t ceilOf(std::int64_t n, std::int64_t d) { return n >= 0 ? (n + d - 1) / d : -(-n / d); }

void expectExact(const TriangleVertex& top, const TriangleVertex& bottom) {
  EdgeColumns edge(top, bottom);
  for (std::int64_t v = 0; v < bottom.v - top.v; ++v, edge.next())
    ASSERT_EQ(edge.column(), top.u + ceilOf(v * (bottom.u - top.u), bottom.v - top.v))
        << top.u << " " << top.v << " to " << bottom.u << " " << bottom.v << ", row " << v;
}

TEST(EdgeColumns, AreExactInTheLargestImages) {
  std::mt19937 random(1);
  const auto below = [&random](int n) { return static_cast<int>(random() % n); };
  for (const int size : {16, 640, 16001})
    for (int i = 0; i < 300; ++i) {
      const int v0 = below(size - 1);
      expectExact({below(size), v0, 0}, {below(size), v0 + 1 + below(size - 1 - v0), 0});
    }
  // The steepest and the flattest ones, and crossings of columns at their last rows.
  for (const int sign : {-1, 1})
    for (const int columns : {0, 1, 2, 7999, 8000, 15998, 15999, 16000})
      for (const int rows : {1, 2, 3, 7999, 8000, 15999, 16000})
        expectExact({sign < 0 ? 16000 : 0, 0, 0}, {sign < 0 ? 16000 - columns : columns, rows, 0});
}

// Pixel (u, v) counts as (u + eps, v + eps^2), a point of no edge.
TEST(TriangleRows, HoldThePixelsInsideByTheSignsOfTheirDistancesToTheEdges) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    TriangleVertex p[3];
    for (auto& x : p) x.u = static_cast<int>(random() % 12), x.v = static_cast<int>(random() % 12);
    const auto area = [&](double u, double v, int k) {
      const auto &a = p[k], &b = p[(k + 1) % 3];
      return (b.u - a.u) * (v - a.v) - (b.v - a.v) * (u - a.u);
    };
    const double twice_area = area(p[2].u, p[2].v, 0);
    if (twice_area == 0) continue;
    int count[12][12] = {};
    for (TriangleRows rows(p[0], p[1], p[2]); !rows.done(); rows.next())
      for (int u = rows.first(); u <= rows.last(); ++u) ++count[rows.v()][u];
    for (int v = 0; v < 12; ++v)
      for (int u = 0; u < 12; ++u) {
        bool inside = true;
        for (int k = 0; k < 3; ++k) inside &= area(u + 1e-3, v + 1e-6, k) * twice_area > 0;
        ASSERT_EQ(count[v][u], inside) << u << " " << v;
      }
  }
}

}  // namespace
}  // namespace facetloc::internal
