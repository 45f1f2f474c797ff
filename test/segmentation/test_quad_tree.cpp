// SPDX-License-Identifier: BSD-3-Clause
#include "quad_tree.h"

#include <facetloc/testing/disparity_images.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

using namespace internal;
using test::blankDisparity, test::randomDisparity, test::roomDisparity;

DisparityImage planeOf(int width, int height, float a, float b, float c) {
  DisparityImage image = blankDisparity(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) image.d[static_cast<std::size_t>(v) * width + u] = a * u + b * v + c;
  return image;
}

std::vector<DisparityImage> images() {
  return {roomDisparity(test::tinyCamera(), 1), roomDisparity(test::smallCamera(), 2),
          randomDisparity(61, 47, 0.8, 3),      planeOf(640, 480, 0.25f, -0.125f, 500),
          planeOf(157, 99, 0.25f, 1, 500),      blankDisparity(64, 64)};
}

TEST(QuadTree, LeavesDoNotOverlapAndCellsKnowTheirs) {
  QuadTree tree;
  for (const DisparityImage& image : images()) {
    tree.compute(image);
    EXPECT_EQ(tree.columns(), (image.camera.width + 3) / 4);
    EXPECT_EQ(tree.rows(), (image.camera.height + 3) / 4);
    std::vector<int> leaf_of_cell(static_cast<std::size_t>(tree.columns()) * tree.rows(), -1);
    for (std::size_t i = 0; i < tree.leaves().size(); ++i) {
      const QuadTree::Leaf& leaf = tree.leaves()[i];
      EXPECT_EQ(leaf.u % leaf.size, 0);
      EXPECT_EQ(leaf.v % leaf.size, 0);
      for (int v = leaf.v / 4; v < (leaf.v + leaf.size) / 4; ++v)
        for (int u = leaf.u / 4; u < (leaf.u + leaf.size) / 4; ++u) {
          int& cell = leaf_of_cell.at(static_cast<std::size_t>(v) * tree.columns() + u);
          EXPECT_EQ(cell, -1) << "leaves " << cell << " and " << i << " overlap";
          cell = static_cast<int>(i);
        }
    }
    EXPECT_EQ(tree.leafOfCell(), leaf_of_cell);
  }
}

TEST(QuadTree, MomentsOfALeafAreTheSumOverItsPixels) {
  QuadTree tree;
  for (const DisparityImage& image : images()) {
    tree.compute(image);
    const int w = image.camera.width, h = image.camera.height;
    for (const QuadTree::Leaf& leaf : tree.leaves()) {
      PlaneMoments sum;
      for (int v = leaf.v; v < std::min(h, leaf.v + leaf.size); ++v)
        for (int u = leaf.u; u < std::min(w, leaf.u + leaf.size); ++u)
          if (const float d = image.d[static_cast<std::size_t>(v) * w + u]; d > 0) sum.add(u, v, d);
      EXPECT_EQ(leaf.moments.n, sum.n);
      EXPECT_EQ(leaf.moments.uu, sum.uu);
      EXPECT_EQ(leaf.moments.uv, sum.uv);
      EXPECT_NEAR(leaf.moments.d, sum.d, 1e-9 * sum.d);
      EXPECT_NEAR(leaf.moments.ud, sum.ud, 1e-9 * sum.ud);
      EXPECT_NEAR(leaf.moments.dd, sum.dd, 1e-9 * sum.dd);
      EXPECT_LE(std::sqrt(sum.fit().sse / sum.n), 1.001 * MergeParams{}.tolerance);
    }
  }
}

TEST(QuadTree, APlaneIsLargestCells) {
  QuadTree tree;
  tree.compute(planeOf(640, 448, 0.5f, -0.25f, 700));
  EXPECT_EQ(tree.leaves().size(), 70u);  // leaves of 64 px
  for (const QuadTree::Leaf& leaf : tree.leaves()) EXPECT_EQ(leaf.size, 64);
  // Where the image ends before the larger ones, smaller ones go on, down to cells that are cut off.
  tree.compute(planeOf(66, 64, 0.5f, -0.25f, 700));
  ASSERT_EQ(tree.leaves().size(), 1u + 16u);
  EXPECT_EQ(tree.leaves()[0].size, 64);
  for (int i = 1; i <= 16; ++i) EXPECT_EQ(tree.leaves()[i].moments.n, 2 * 4);
}

TEST(QuadTree, AStepIsInNoCellButTheSmallest) {
  DisparityImage image = planeOf(128, 64, 0, 0, 400);
  for (int v = 0; v < 64; ++v) std::fill_n(image.d.begin() + v * 128 + 34, 128 - 34, 420.f);
  QuadTree tree;
  tree.compute(image);
  for (const QuadTree::Leaf& leaf : tree.leaves()) EXPECT_FALSE(leaf.u < 34 && leaf.u + leaf.size > 34);
  for (int row = 0; row < tree.rows(); ++row) EXPECT_EQ(tree.leafOfCell()[row * tree.columns() + 8], -1);
  EXPECT_EQ(tree.leaves()[0].size, 64);  // right of the middle
}

// The one by displacement: each half has no residual of its own, and the residual of both is within the
// tolerance.
TEST(QuadTree, PartsThatAreTwoPlanesAreNotJoined) {
  for (const float step : {2.f, 10.f}) {
    DisparityImage image = planeOf(8, 8, 0, 0, 400);
    for (int v = 0; v < 8; ++v) std::fill_n(image.d.begin() + v * 8 + 4, 4, 400.f + step);
    const double rms =
        step / 4;  // residual of both halves to their plane, to which they are parallel no more
    QuadTree tree(1.01 * rms);
    tree.compute(image);
    EXPECT_EQ(tree.leaves().size(), 4u) << "their displacement is twice that";
  }
}

// Every pair of leaves that share a side, or a part of one, by looking at all neighbouring cells.
TEST(QuadTree, CommonSidesAreMetOnce) {
  QuadTree tree;
  for (const DisparityImage& image : images()) {
    tree.compute(image);
    std::set<std::pair<int, int>> expected;
    const auto add = [&](int a, int b) {
      if (a >= 0 && b >= 0 && a != b) expected.insert(std::minmax(a, b));
    };
    const std::vector<std::int32_t>& leaf = tree.leafOfCell();
    for (int row = 0; row < tree.rows(); ++row)
      for (int column = 0; column < tree.columns(); ++column) {
        const int cell = row * tree.columns() + column;
        if (column + 1 < tree.columns()) add(leaf[cell], leaf[cell + 1]);
        if (row + 1 < tree.rows()) add(leaf[cell], leaf[cell + tree.columns()]);
      }
    std::set<std::pair<int, int>> met;
    tree.forEachCommonSide([&](int a, int b) {
      EXPECT_TRUE(met.insert(std::minmax(a, b)).second) << a << " and " << b << " met twice";
    });
    EXPECT_EQ(met, expected);
  }
}

TEST(QuadTree, NothingHasNoLeaf) {
  QuadTree tree;
  for (const DisparityImage& image : {DisparityImage{}, blankDisparity(10, 10), blankDisparity(1, 1)}) {
    tree.compute(roomDisparity(test::tinyCamera(), 1));  // leaves that could go stale
    tree.compute(image);
    EXPECT_TRUE(tree.leaves().empty());
    tree.forEachCommonSide([](int, int) { FAIL(); });
  }
}

}  // namespace
}  // namespace facetloc
