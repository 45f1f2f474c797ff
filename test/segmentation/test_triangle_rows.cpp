// SPDX-License-Identifier: BSD-3-Clause
#include "triangle_rows.h"

#include <gtest/gtest.h>

#include <random>

namespace facetloc {

using namespace internal;
namespace {

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
}  // namespace facetloc
