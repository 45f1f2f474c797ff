// SPDX-License-Identifier: BSD-3-Clause
#include "depth_triangulation.h"

#include <facetloc/testing/disparity_images.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

namespace facetloc {
namespace {

using namespace internal;
using test::blankDisparity, test::randomDisparity, test::roomDisparity;
using Vertex = DepthTriangulation::Vertex;
using Triangle = DepthTriangulation::Triangle;

// ---- oracles, in integers wide enough for anything

__extension__ typedef __int128 Wide;

Wide orientation(const Vertex& a, const Vertex& b, const Vertex& c) {
  return Wide(b.u - a.u) * (c.v - a.v) - Wide(b.v - a.v) * (c.u - a.u);
}

// Positive if d lies strictly inside the circle through a, b, c of positive orientation.
Wide inCircle(const Vertex& a, const Vertex& b, const Vertex& c, const Vertex& d) {
  const Wide m[3][2] = {{a.u - d.u, a.v - d.v}, {b.u - d.u, b.v - d.v}, {c.u - d.u, c.v - d.v}};
  const auto square = [&](int i) { return m[i][0] * m[i][0] + m[i][1] * m[i][1]; };
  const auto minor = [&](int i, int k) { return m[i][0] * m[k][1] - m[i][1] * m[k][0]; };
  return square(0) * minor(1, 2) - square(1) * minor(0, 2) + square(2) * minor(0, 1);
}

DepthTriangulation splitOf(const DisparityImage& image, const SplitParams& params = {}) {
  DepthTriangulation split(params);
  split.compute(image);
  return split;
}

struct Named {
  std::string name;
  DisparityImage image;
  friend void PrintTo(const Named& n, std::ostream* out) { *out << n.name; }  // not its bytes
};

std::vector<Named> images() {
  std::vector<Named> list;
  list.push_back({"room", roomDisparity(test::tinyCamera(), 1)});
  list.push_back({"exact room", roomDisparity(test::tinyCamera(), 1, 0)});
  list.push_back({"noise", randomDisparity(60, 45, 1.0, 2)});
  list.push_back({"noise with holes", randomDisparity(64, 48, 0.6, 3)});
  list.push_back({"sparse", randomDisparity(64, 48, 0.02, 4)});
  list.push_back({"narrow", randomDisparity(2, 50, 1.0, 5)});
  list.push_back({"flat", randomDisparity(50, 2, 1.0, 6)});
  list.push_back({"two by two", randomDisparity(2, 2, 1.0, 7)});
  DisparityImage constant = blankDisparity(31, 17);
  std::fill(constant.d.begin(), constant.d.end(), 300.f);
  list.push_back({"constant", constant});
  DisparityImage patch = blankDisparity(160, 120);  // nothing in it deviates
  for (int v = 33; v < 77; ++v)
    for (int u = 51; u < 95; ++u) patch.d[static_cast<std::size_t>(v) * 160 + u] = 300;
  list.push_back({"constant patch", patch});
  DisparityImage hole = roomDisparity(test::tinyCamera(), 8);
  for (int v = 30; v < 90; ++v)
    for (int u = 50; u < 130; ++u) hole.d[static_cast<std::size_t>(v) * 160 + u] = 0;
  list.push_back({"large hole", hole});
  DisparityImage grid = blankDisparity(33, 33);  // cocircular vertices everywhere
  for (int v = 0; v < 33; ++v)
    for (int u = 0; u < 33; ++u)
      grid.d[static_cast<std::size_t>(v) * 33 + u] = (u % 8 == 0) && (v % 8 == 0) ? 900.f : 100.f;
  list.push_back({"grid", grid});
  return list;
}

class EveryImage : public testing::TestWithParam<Named> {
protected:
  void SetUp() override { split.compute(image()); }
  const DisparityImage& image() const { return GetParam().image; }
  const Vertex& vertex(int i) const { return split.vertices()[i]; }
  DepthTriangulation split;
};

TEST_P(EveryImage, IsADelaunayTriangulation) {
  ASSERT_FALSE(split.triangles().empty());
  for (const Triangle& t : split.triangles()) {
    const Vertex &a = vertex(t.vertex[0]), &b = vertex(t.vertex[1]), &c = vertex(t.vertex[2]);
    ASSERT_GT(orientation(a, b, c), 0);
    for (const Vertex& d : split.vertices())
      ASSERT_LE(inCircle(a, b, c, d), 0) << "(" << d.u << ", " << d.v << ") lies in a circumcircle";
  }
}

TEST_P(EveryImage, TrianglesCoverTheImageOnce) {
  Wide twice_area = 0;
  int border_edges = 0;
  for (const Triangle& t : split.triangles()) {
    twice_area += orientation(vertex(t.vertex[0]), vertex(t.vertex[1]), vertex(t.vertex[2]));
    border_edges += static_cast<int>(std::count(t.neighbour.begin(), t.neighbour.end(), -1));
  }
  const int w = image().camera.width, h = image().camera.height;
  EXPECT_EQ(static_cast<long>(twice_area), 2l * w * h);
  // Euler: a triangulation of n points, b of them on the border, has 2 n - 2 - b triangles.
  EXPECT_EQ(split.triangles().size(), 2 * split.vertices().size() - 2 - border_edges);
}

TEST_P(EveryImage, RowsPartitionTheImage) {
  const int w = image().camera.width;
  std::vector<int> count(image().d.size(), 0);
  for (const Triangle& t : split.triangles()) {
    int pixels = 0;
    for (TriangleRows rows = split.rows(t); !rows.done(); rows.next())
      for (int u = rows.first(); u <= rows.last(); ++u, ++pixels)
        ++count.at(static_cast<std::size_t>(rows.v()) * w + u);
    EXPECT_EQ(pixels, t.num_pixels);
  }
  EXPECT_TRUE(std::all_of(count.begin(), count.end(), [](int n) { return n == 1; }));
}

TEST_P(EveryImage, NeighboursShareTheirEdge) {
  const auto& triangles = split.triangles();
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const int j = triangles[i].neighbour[k];
      const int a = triangles[i].vertex[k], b = triangles[i].vertex[(k + 1) % 3];
      if (j < 0) {  // on the border of the image
        const int w = image().camera.width, h = image().camera.height;
        EXPECT_TRUE((vertex(a).u == vertex(b).u && (vertex(a).u == 0 || vertex(a).u == w)) ||
                    (vertex(a).v == vertex(b).v && (vertex(a).v == 0 || vertex(a).v == h)));
        continue;
      }
      int shared = 0;
      for (int m = 0; m < 3; ++m)
        if (triangles[j].neighbour[m] == static_cast<int>(i) && triangles[j].vertex[m] == b &&
            triangles[j].vertex[(m + 1) % 3] == a)
          ++shared;
      EXPECT_EQ(shared, 1);
    }
}

TEST_P(EveryImage, TrianglesKnowTheirPlaneAndTheirWorstRow) {
  for (const Triangle& t : split.triangles()) {
    for (const int k : t.vertex)
      EXPECT_NEAR(t.plane.at(vertex(k).u, vertex(k).v), vertex(k).d, 1e-3 * (1 + std::abs(vertex(k).d)));
    int valid = 0;
    double largest = 0, of_row = 0;
    for (TriangleRows rows = split.rows(t); !rows.done(); rows.next())
      for (int u = rows.first(); u <= rows.last(); ++u) {
        const int i = rows.v() * image().camera.width + u;
        if (!(image().d[i] > 0)) continue;
        ++valid;
        const double e = std::abs(image().d[i] - t.plane.at(u, rows.v()));
        largest = std::max(largest, e);
        if (rows.v() == t.worst_row / image().camera.width) of_row = std::max(of_row, e);
      }
    EXPECT_EQ(t.num_valid, valid);
    EXPECT_NEAR(t.max_deviation, largest, 2e-3);
    EXPECT_NEAR(of_row, largest, 2e-3);
  }
}

TEST_P(EveryImage, VerticesArePutWhereATriangleDeviatesMost) {
  constexpr int kGrid = 20;  // corners and grid, at most
  for (int n = kGrid; n < 60; ++n) {
    SplitParams p;
    p.max_vertices = n;
    const DepthTriangulation before = splitOf(image(), p);
    p.max_vertices = n + 1;
    const DepthTriangulation after = splitOf(image(), p);
    if (static_cast<int>(after.vertices().size()) <= n) return;
    const Vertex& added = after.vertices().back();
    for (const Triangle& t : before.triangles()) {
      bool is_inside = false;
      for (TriangleRows rows = before.rows(t); !rows.done(); rows.next())
        is_inside = is_inside || (rows.v() == added.v && rows.first() <= added.u && added.u <= rows.last());
      if (!is_inside || !(t.max_deviation > p.tolerance)) continue;
      EXPECT_NEAR(std::abs(added.d - t.plane.at(added.u, added.v)), t.max_deviation, 2e-3);
    }
  }
}

TEST_P(EveryImage, NothingIsLeftToRefine) {
  const SplitParams p;
  const double fill_pixels = std::max(7.0, scaledPixels(20, image().camera));
  for (const Triangle& t : split.triangles()) {
    const bool flat = t.max_deviation <= p.tolerance;
    const bool filled = t.num_pixels < fill_pixels || t.num_valid >= kMinFill * t.num_pixels;
    const double area =
        0.5 * static_cast<double>(orientation(vertex(t.vertex[0]), vertex(t.vertex[1]), vertex(t.vertex[2])));
    const bool small = area <= scaledPixels(p.min_area, image().camera);
    bool worst_is_vertex = t.worst_pixel < 0;
    for (const int k : t.vertex)
      worst_is_vertex = worst_is_vertex || vertex(k).v * image().camera.width + vertex(k).u == t.worst_pixel;
    const bool sparse = t.num_valid < fill_pixels;
    EXPECT_TRUE((flat && filled) || small || (worst_is_vertex && (filled || sparse)));
  }
}

TEST_P(EveryImage, VerticesAreDistinctValidPixelsOrCorners) {
  std::set<std::pair<int, int>> seen;
  for (std::size_t i = 0; i < split.vertices().size(); ++i) {
    const Vertex& p = vertex(static_cast<int>(i));
    EXPECT_TRUE(seen.insert({p.u, p.v}).second);
    EXPECT_GT(p.d, 0);
    if (i >= 4) {
      EXPECT_EQ(p.d, image().d[static_cast<std::size_t>(p.v) * image().camera.width + p.u]);
    }
  }
}

TEST_P(EveryImage, TwoRunsAgreeInEveryNumber) {
  DepthTriangulation again;
  again.compute(roomDisparity(test::tinyCamera(), 99));  // buffers of another image do not matter
  again.compute(image());
  ASSERT_EQ(again.vertices().size(), split.vertices().size());
  ASSERT_EQ(again.triangles().size(), split.triangles().size());
  for (std::size_t i = 0; i < split.triangles().size(); ++i) {
    EXPECT_EQ(again.triangles()[i].vertex, split.triangles()[i].vertex);
    EXPECT_EQ(again.triangles()[i].neighbour, split.triangles()[i].neighbour);
    EXPECT_EQ(again.triangles()[i].max_deviation, split.triangles()[i].max_deviation);
  }
}

INSTANTIATE_TEST_SUITE_P(DepthTriangulation, EveryImage, testing::ValuesIn(images()), [](const auto& i) {
  std::string name = i.param.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

// ---- special cases

TEST(DepthTriangulation, OfAnEmptyImageIsEmpty) {
  DepthTriangulation split;
  for (const DisparityImage& image :
       {DisparityImage{}, blankDisparity(40, 30), blankDisparity(1, 1), randomDisparity(1, 1, 1, 1),
        randomDisparity(1, 50, 1, 1), randomDisparity(50, 1, 1, 1), blankDisparity(2, 2)}) {
    split.compute(roomDisparity(test::tinyCamera(), 1));
    split.compute(image);
    EXPECT_TRUE(split.triangles().empty());
    EXPECT_TRUE(split.vertices().empty());
  }
}

TEST(DepthTriangulation, DisparitiesLikeInfinityLeaveItATriangulation) {
  for (const float huge : {3e38f, std::numeric_limits<float>::infinity()})
    for (unsigned seed = 0; seed < 50; ++seed) {
      DisparityImage image = randomDisparity(64, 48, seed % 3 == 0 ? 0.3 : 0.8, seed);
      if (seed % 2)
        for (float& d : image.d) d = d > 0 ? 300.f : 0.f;
      test::Rng rng(seed);
      for (unsigned i = 0; i <= seed % 7; ++i)
        image.d[static_cast<std::size_t>(test::uniform(rng, 0, 64 * 48 - 1))] = huge;
      const DepthTriangulation split = splitOf(image);
      int pixels = 0;
      for (const Triangle& t : split.triangles()) {
        ASSERT_GT(orientation(split.vertices()[t.vertex[0]], split.vertices()[t.vertex[1]],
                              split.vertices()[t.vertex[2]]),
                  0);
        pixels += t.num_pixels;
      }
      EXPECT_EQ(pixels, 64 * 48);
    }
}

TEST(DepthTriangulation, OneValidPixelGivesAPlaneThroughIt) {
  for (const int at : {0, 39, 620, 1199}) {
    DisparityImage image = blankDisparity(40, 30);
    image.d[at] = 500;
    const DepthTriangulation split = splitOf(image);
    ASSERT_FALSE(split.triangles().empty());
    for (const Vertex& p : split.vertices()) EXPECT_EQ(p.d, 500);
    for (const Triangle& t : split.triangles()) EXPECT_EQ(t.max_deviation, 0);
  }
}

TEST(DepthTriangulation, AnExactPlaneIsTheGridItStartsWith) {
  struct Size {
    int width, height, grid;
  };
  for (const auto& [w, h, grid] :
       {Size{64, 48, 4 * 3}, {320, 240, 4 * 3}, {640, 480, 8 * 6}, {5120, 320, 32 * 2}}) {
    DisparityImage image = blankDisparity(w, h);
    for (int v = 0; v < h; ++v)
      for (int u = 0; u < w; ++u)
        image.d[static_cast<std::size_t>(v) * w + u] = static_cast<float>(2000 + 2 * u - v);
    const DepthTriangulation split = splitOf(image);
    EXPECT_EQ(split.vertices().size(), 4u + grid) << w;
    // Corners outside the image have the depth of the pixel beside them.
    for (const Triangle& t : split.triangles()) EXPECT_LE(t.max_deviation, 2) << w;
  }
}

TEST(DepthTriangulation, TheFillRuleIsScaledWithTheImage) {
  DisparityImage image = randomDisparity(640, 480, 0.4, 5);
  for (float& d : image.d) d = d > 0 ? 300.f : 0.f;
  const DepthTriangulation split = splitOf(image);
  const auto poorlyFilled = [&](double size) {
    return std::count_if(split.triangles().begin(), split.triangles().end(), [&](const Triangle& t) {
      return t.num_valid >= size && t.num_valid < 0.5 * t.num_pixels;
    });
  };
  EXPECT_EQ(poorlyFilled(80), 0);
  EXPECT_GT(poorlyFilled(20), 0);  // which at 320x240 would be refined
}

TEST(DepthTriangulation, SmallTrianglesAreNotRefined) {
  const DisparityImage image = randomDisparity(64, 48, 1, 3);  // wants a vertex at each pixel
  SplitParams params;
  params.min_area = 8 / scaledPixels(1, image.camera);  // 8 px of this image
  const DepthTriangulation split = splitOf(image, params);
  const std::size_t refined = split.vertices().size();
  for (const Triangle& t : split.triangles()) {
    const auto& v = split.vertices();
    const auto twice_area = orientation(v[t.vertex[0]], v[t.vertex[1]], v[t.vertex[2]]);
    EXPECT_TRUE(twice_area <= 16 || t.max_deviation <= params.tolerance);
  }
  params.min_area = 0;
  const DepthTriangulation whole = splitOf(image, params);
  EXPECT_GT(whole.vertices().size(), refined);
}

TEST(DepthTriangulation, CornersWithoutDepthTakeThatOfTheNearestPixel) {
  DisparityImage image = blankDisparity(40, 30);
  for (int v = 10; v < 20; ++v)
    for (int u = 10; u < 30; ++u) image.d[static_cast<std::size_t>(v) * 40 + u] = u < 20 ? 100.f : 104.f;
  const DepthTriangulation split = splitOf(image);
  const float want[] = {100, 104, 104, 100};
  for (int k = 0; k < 4; ++k) EXPECT_EQ(split.vertices()[k].d, want[k]);
}

TEST(DepthTriangulation, VertexLimitIsKept) {
  const auto limited = [](const DisparityImage& image, int limit) {
    SplitParams params;
    params.max_vertices = limit;
    return splitOf(image, params).vertices().size();
  };
  EXPECT_EQ(limited(randomDisparity(64, 48, 1, 1), 50), 50u);
  for (const int limit : {4, 10})
    EXPECT_EQ(limited(randomDisparity(64, 48, 1, 1), limit), std::size_t(limit)) << "by the grid as well";
  EXPECT_EQ(limited(randomDisparity(8, 800, 1, 1), 100), 100u) << "where the grid would have 1600";
}

TEST(DepthTriangulation, TrianglesKnowAllTheirPixelsAtTheVertexLimit) {
  const DisparityImage image = randomDisparity(320, 240, 1, 1);
  SplitParams params;
  params.max_vertices = 12;
  const DepthTriangulation split = splitOf(image, params);
  for (const Triangle& t : split.triangles()) {
    int pixels = 0, valid = 0;
    double largest = 0;
    for (TriangleRows rows = split.rows(t); !rows.done(); rows.next())
      for (int u = rows.first(); u <= rows.last(); ++u) {
        const float d = image.d[static_cast<std::size_t>(rows.v()) * 320 + u];
        ++pixels;
        if (!(d > 0)) continue;
        ++valid;
        largest = std::max(largest, std::abs(d - t.plane.at(u, rows.v())));
      }
    EXPECT_EQ(t.num_pixels, pixels);
    EXPECT_EQ(t.num_valid, valid);
    EXPECT_NEAR(t.max_deviation, largest, 2e-3 * (1 + largest));
  }
}

TEST(DepthTriangulation, IsExactAtTheLargestSize) {
  DisparityImage image = blankDisparity(2048, 2048);
  for (int v = 0; v < 2048; ++v)
    for (int u = 0; u < 2048; ++u)
      image.d[static_cast<std::size_t>(v) * 2048 + u] =
          static_cast<float>(500 + std::abs(u - 1023) * 0.5 + 40 * ((u / 700 + v / 500) % 2));
  SplitParams params;
  params.max_vertices = 1000;  // the grid has 676
  const DepthTriangulation split = splitOf(image, params);
  for (const Triangle& t : split.triangles()) {
    const Vertex &a = split.vertices()[t.vertex[0]], &b = split.vertices()[t.vertex[1]],
                 &c = split.vertices()[t.vertex[2]];
    ASSERT_GT(orientation(a, b, c), 0);
    for (const Vertex& d : split.vertices()) ASSERT_LE(inCircle(a, b, c, d), 0);
  }
}

TEST(DepthTriangulation, AConstantOffsetChangesNothing) {
  const DisparityImage image = roomDisparity(test::smallCamera(), 5);
  DisparityImage shifted = image;
  for (float& d : shifted.d)
    if (d > 0) d += 256;
  const DepthTriangulation a = splitOf(image), b = splitOf(shifted);
  ASSERT_EQ(a.vertices().size(), b.vertices().size());
  for (std::size_t i = 0; i < a.vertices().size(); ++i) {
    EXPECT_EQ(a.vertices()[i].u, b.vertices()[i].u);
    EXPECT_EQ(a.vertices()[i].v, b.vertices()[i].v);
  }
  ASSERT_EQ(a.triangles().size(), b.triangles().size());
  for (std::size_t i = 0; i < a.triangles().size(); ++i)
    EXPECT_EQ(a.triangles()[i].vertex, b.triangles()[i].vertex);
}

}  // namespace
}  // namespace facetloc
