// SPDX-License-Identifier: BSD-3-Clause
#include "region_merging.h"

#include <facetloc/testing/disparity_images.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

using namespace internal;
using test::blankDisparity, test::randomDisparity, test::Rng, test::roomDisparity, test::uniform;

struct Merged {
  explicit Merged(const DisparityImage& image, const MergeParams& params = {}) : merging(params) {
    split.compute(image);
    merging.compute(split, image);
  }
  DepthTriangulation split;
  RegionMerging merging;
};

PlaneMoments momentsOf(const std::vector<Eigen::Vector3d>& pixels) {
  PlaneMoments m;
  for (const Eigen::Vector3d& p : pixels) m.add(p.x(), p.y(), p.z());
  return m;
}

std::vector<Eigen::Vector3d> randomRegion(Rng& rng, int n) {
  const PixelPlane plane{uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, 100, 300)};
  const double u0 = uniform(rng, 0, 200), v0 = uniform(rng, 0, 200);
  std::vector<Eigen::Vector3d> pixels;
  for (int i = 0; i < n; ++i) {
    const double u = std::floor(u0 + uniform(rng, 0, 30)), v = std::floor(v0 + uniform(rng, 0, 30));
    pixels.emplace_back(u, v, plane.at(u, v) + test::gaussian<1>(rng)[0]);
  }
  return pixels;
}

TEST(RegionMerging, CostIsTheLargerOfResidualAndDisplacement) {
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const auto a = randomRegion(rng, 10 + i), b = randomRegion(rng, 200 - i);
    auto both = a;
    both.insert(both.end(), b.begin(), b.end());
    const double sse_a = test::squaredResiduals(a), sse_b = test::squaredResiduals(b),
                 sse = test::squaredResiduals(both), rms = std::sqrt(sse / both.size());
    const double displacement = std::sqrt((sse - sse_a - sse_b) / std::min(a.size(), b.size()));
    const double cost = RegionMerging::cost(momentsOf(a), sse_a, momentsOf(b), sse_b);
    EXPECT_NEAR(cost, std::max(rms, displacement), 1e-5 * (1 + cost));
    EXPECT_GE(cost, 0);
    EXPECT_DOUBLE_EQ(RegionMerging::cost(momentsOf(b), sse_b, momentsOf(a), sse_a), cost);
  }
}

TEST(RegionMerging, HalvesOfAPlaneCostNothing) {
  EXPECT_EQ(RegionMerging::cost({}, 0, {}, 0), 0);
  PlaneMoments a, b;
  for (int u = 0; u < 20; ++u)
    for (int v = 0; v < 20; ++v) (u < 10 ? a : b).add(u, v, 100 + 2 * u - v);
  EXPECT_NEAR(RegionMerging::cost(a, 0, b, 0), 0, 1e-3);
}

TEST(RegionMerging, ASmallRegionSeveralSigmaAwayIsNotSwallowed) {
  PlaneMoments large, small;
  for (int u = 0; u < 100; ++u)
    for (int v = 0; v < 100; ++v) large.add(u, v, 200);
  for (int u = 100; u < 105; ++u)
    for (int v = 0; v < 5; ++v) small.add(u, v, 205);
  const double rms = std::sqrt((large + small).fit().sse / (large + small).n);
  EXPECT_LT(rms, 0.5);  // the residual alone would merge them
  EXPECT_GT(RegionMerging::cost(large, 0, small, 0), 4);
}

TEST(RegionMerging, MomentsOfARegionAreTheSumOverItsPixels) {
  for (const DisparityImage& image : {roomDisparity(test::tinyCamera(), 1), randomDisparity(64, 48, 0.7, 2),
                                      randomDisparity(64, 48, 0.3, 3)}) {
    const Merged m(image);
    std::vector<PlaneMoments> sum(m.merging.regions().size());
    ASSERT_EQ(m.merging.regionOfLeaf().size(), m.split.triangles().size());
    for (std::size_t t = 0; t < m.split.triangles().size(); ++t) {
      const int r = m.merging.regionOfLeaf()[t];
      if (r < 0) continue;
      for (TriangleRows rows = m.split.rows(m.split.triangles()[t]); !rows.done(); rows.next())
        for (int u = rows.first(); u <= rows.last(); ++u) {
          const float d = image.d[static_cast<std::size_t>(rows.v()) * image.camera.width + u];
          if (d > 0) sum.at(r).add(u, rows.v(), d);
        }
    }
    for (std::size_t r = 0; r < sum.size(); ++r) {
      const PlaneMoments& got = m.merging.regions()[r].moments;
      EXPECT_GT(got.n, 0);
      EXPECT_EQ(got.n, sum[r].n);
      EXPECT_EQ(got.u, sum[r].u);
      EXPECT_EQ(got.v, sum[r].v);
      EXPECT_EQ(got.uu, sum[r].uu);
      EXPECT_EQ(got.uv, sum[r].uv);
      EXPECT_EQ(got.vv, sum[r].vv);
      EXPECT_NEAR(got.d, sum[r].d, 1e-9 * sum[r].d);
      EXPECT_NEAR(got.dd, sum[r].dd, 1e-9 * sum[r].dd);
      const PixelPlane fitted = got.fit().plane;
      EXPECT_EQ(m.merging.regions()[r].plane.a, fitted.a);
      EXPECT_EQ(m.merging.regions()[r].plane.c, fitted.c);
    }
  }
}

TEST(RegionMerging, RegionsAreConnectedAndNoNeighboursCouldStillMerge) {
  const DisparityImage image = roomDisparity(test::tinyCamera(), 4);
  const Merged m(image);
  const auto& region = m.merging.regionOfLeaf();
  const auto& triangles = m.split.triangles();
  // Connected: the triangles of a region are reached from one of them over shared edges.
  std::vector<char> reached(triangles.size(), 0), begun(m.merging.regions().size(), 0);
  for (std::size_t start = 0; start < triangles.size(); ++start) {
    if (region[start] < 0 || reached[start]) continue;
    EXPECT_FALSE(begun[region[start]]) << "region " << region[start] << " falls apart";
    begun[region[start]] = 1;
    std::vector<int> stack{static_cast<int>(start)};
    reached[start] = 1;
    while (!stack.empty()) {
      const int t = stack.back();
      stack.pop_back();
      for (const int j : triangles[t].neighbour)
        if (j >= 0 && !reached[j] && region[j] == region[t]) reached[j] = 1, stack.push_back(j);
    }
  }
  // Finished: every pair of neighbouring regions costs more than the tolerance.
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int j : triangles[t].neighbour) {
      if (j < 0 || region[t] < 0 || region[j] < 0 || region[j] == region[t]) continue;
      const PlaneMoments &a = m.merging.regions()[region[t]].moments,
                         &b = m.merging.regions()[region[j]].moments;
      EXPECT_GT(RegionMerging::cost(a, a.fit().sse, b, b.fit().sse), m.merging.params().tolerance - 1e-6);
    }
}

TEST(RegionMerging, ACheaperCutIsARefinementInNumbers) {
  const DisparityImage image = roomDisparity(test::tinyCamera(), 5);
  std::size_t before = 0;
  for (const double tolerance : {20.0, 5.0, 2.75, 1.5, 0.5}) {
    MergeParams params;
    params.tolerance = tolerance;
    const std::size_t regions = Merged(image, params).merging.regions().size();
    EXPECT_GE(regions, before);
    before = regions;
  }
}

TEST(RegionMerging, PoorlyFilledTrianglesAndDiscontinuitiesBelongToNoRegion) {
  DisparityImage image = blankDisparity(64, 48);
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u)
      if (u < 20 || u >= 44) image.d[static_cast<std::size_t>(v) * 64 + u] = u < 20 ? 200.f : 600.f;
  const Merged m(image);
  for (std::size_t t = 0; t < m.split.triangles().size(); ++t) {
    const auto& triangle = m.split.triangles()[t];
    if (triangle.num_valid < 0.5 * triangle.num_pixels || triangle.num_valid == 0) {
      EXPECT_EQ(m.merging.regionOfLeaf()[t], -1);
    }
  }
  EXPECT_EQ(m.merging.regions().size(), 2u);
}

// Both are well filled: a triangle that may not be refined, across a step, and a plane that nearly meets the
// camera.
TEST(RegionMerging, StepsAndPlanesThroughTheCameraBelongToNoRegion) {
  DisparityImage image = blankDisparity(64, 48);
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) image.d[static_cast<std::size_t>(v) * 64 + u] = u < 32 ? 200.f : 600.f;
  SplitParams coarse;
  coarse.min_area = 1e6;
  DepthTriangulation split(coarse);
  split.compute(image);
  RegionMerging merging;
  merging.compute(split, image);
  int across = 0;
  for (std::size_t t = 0; t < split.triangles().size(); ++t) {
    if (!(split.triangles()[t].max_deviation > coarse.tolerance)) continue;
    EXPECT_EQ(merging.regionOfLeaf()[t], -1);
    ++across;
  }
  EXPECT_GT(across, 0);

  MergeParams params;
  std::fill(image.d.begin(), image.d.end(), 200.f);
  DepthTriangulation flat;
  flat.compute(image);
  for (const bool near : {false, true}) {
    const double distance = 1 / (image.unit * 200);
    params.min_plane_distance = near ? 1.01 * distance : 0.99 * distance;
    RegionMerging of_wall(params);
    of_wall.compute(flat, image);
    EXPECT_EQ(of_wall.regions().size(), near ? 0u : 1u);
  }
}

TEST(RegionMerging, OfAnEmptyImageIsEmpty) {
  for (const DisparityImage& image :
       {DisparityImage{}, blankDisparity(10, 10), randomDisparity(1, 1, 1, 1)}) {
    const Merged m(image);
    EXPECT_TRUE(m.merging.regions().empty());
    EXPECT_TRUE(m.merging.regionOfLeaf().empty());
  }
}

TEST(RegionMerging, AConstantOffsetChangesNothing) {
  const DisparityImage image = roomDisparity(test::smallCamera(), 6);
  DisparityImage shifted = image;
  for (float& d : shifted.d)
    if (d > 0) d += 256;
  MergeParams params;
  params.min_plane_distance = 0;  // the one criterion that is about space, not about disparity
  const Merged a(image, params), b(shifted, params);
  EXPECT_EQ(a.merging.regionOfLeaf(), b.merging.regionOfLeaf());
}

// A room, cut into cells: the same rules hold, and neighbours are cells with a common side.
TEST(RegionMerging, RegionsOfCellsAreSumsAndNoNeighboursCouldStillMerge) {
  const DisparityImage image = roomDisparity(test::tinyCamera(), 4);
  QuadTree tree;
  tree.compute(image);
  RegionMerging merging;
  merging.compute(tree, image);
  const auto& regions = merging.regions();
  const auto& region = merging.regionOfLeaf();
  ASSERT_EQ(region.size(), tree.leaves().size());
  ASSERT_GE(regions.size(), 4u);
  std::vector<PlaneMoments> sum(regions.size());
  for (std::size_t i = 0; i < region.size(); ++i)
    if (region[i] >= 0) sum.at(region[i]) += tree.leaves()[i].moments;
  for (std::size_t r = 0; r < sum.size(); ++r) {
    EXPECT_EQ(regions[r].moments.n, sum[r].n);
    EXPECT_EQ(regions[r].moments.uv, sum[r].uv);
    EXPECT_NEAR(regions[r].moments.dd, sum[r].dd, 1e-9 * sum[r].dd);
  }
  int sides = 0;
  tree.forEachCommonSide([&](int i, int j) {
    if (region[i] < 0 || region[j] < 0 || region[i] == region[j]) return;
    const PlaneMoments &a = regions[region[i]].moments, &b = regions[region[j]].moments;
    EXPECT_GT(RegionMerging::cost(a, a.fit().sse, b, b.fit().sse), merging.params().tolerance - 1e-6);
    ++sides;
  });
  EXPECT_GT(sides, 0);
}

// A ridge within a column of cells, which are flat all the same; the planes beside it are exact.
TEST(RegionMerging, CellsAcrossAnEdgeDoNotTiltItsPlanes) {
  DisparityImage image = blankDisparity(64, 64);
  for (int v = 0; v < 64; ++v)
    for (int u = 0; u < 64; ++u)
      image.d[static_cast<std::size_t>(v) * 64 + u] = static_cast<float>(400 - std::abs(u - 30));
  QuadTree tree;
  tree.compute(image);
  RegionMerging merging;
  merging.compute(tree, image);
  ASSERT_EQ(merging.regions().size(), 2u);
  for (const RegionMerging::Region& r : merging.regions()) {
    const double slope = r.plane.a > 0 ? 1 : -1;
    EXPECT_NEAR(r.plane.a, slope, 1e-9);
    EXPECT_NEAR(r.plane.b, 0, 1e-9);
    EXPECT_NEAR(r.plane.c, 400 - 30 * slope, 1e-6);
  }
}

TEST(RegionMerging, APlaneOfCellsThroughTheCameraBelongsToNoRegion) {
  DisparityImage image = blankDisparity(64, 48);
  std::fill(image.d.begin(), image.d.end(), 200.f);
  QuadTree tree;
  tree.compute(image);
  for (const bool near : {false, true}) {
    MergeParams params;
    params.min_plane_distance = (near ? 1.01 : 0.99) / (image.unit * 200);
    RegionMerging merging(params);
    merging.compute(tree, image);
    EXPECT_EQ(merging.regions().size(), near ? 0u : 1u);
  }
}

}  // namespace
}  // namespace facetloc
