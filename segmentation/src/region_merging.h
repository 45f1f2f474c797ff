// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth_triangulation.h"
#include "edge_queue.h"
#include "quad_tree.h"

namespace facetloc::internal {

/** \brief Hierarchical clustering of the leaves of a split into planar regions after Garland, Willmott &
 * Heckbert (METHOD 5). Leaves are triangles, or squares of a quad-tree.
 *
 * Contracts the cheapest edge between neighbouring regions first, adds their moments, and stops at
 * the tolerance, which is the cut of the full binary forest at that cost. The cost is the larger of the RMS
 * residual of the union and the displacement of the smaller region, so that a large plane cannot swallow a
 * small one that is several sigma away. Deterministic: ties by index. */
class RegionMerging {
public:
  struct Region {
    PlaneMoments moments;  ///< moments of its valid pixels in (u, v, disparity)
    PixelPlane plane;
  };

  explicit RegionMerging(const MergeParams& params = {}) : params_(params) {}
  const MergeParams& params() const { return params_; }

  void compute(const DepthTriangulation& triangulation, const DisparityImage& image);
  void compute(const QuadTree& tree, const DisparityImage& image);

  const std::vector<Region>& regions() const { return regions_; }
  /** \brief Region of each leaf; -1 for discontinuities and poorly filled triangles. */
  const std::vector<std::int32_t>& regionOfLeaf() const { return region_of_leaf_; }

  /** \brief Cost of making one region of two [units of d]; symmetric, never negative. */
  static double cost(const PlaneMoments& a, double sse_a, const PlaneMoments& b, double sse_b);

private:
  static double squaredCost(const PlaneMoments& a, double sse_a, const PlaneMoments& b, double sse_b);
  struct Node {
    PlaneMoments moments;
    double sse = 0;
    std::int32_t parent = 0;
    std::uint32_t version = 0;
    std::int32_t first = -1, last = -1;  // its list of neighbours, in links_
    std::int32_t degree = 0;             // length of the list
    bool takes_part = false;             // else a discontinuity, or poorly filled
  };
  struct Link {
    std::int32_t node, next;
  };
  void begin(std::size_t leaves);
  void addNode(int leaf, const PlaneMoments& moments, const PlaneMoments::Fit& fit);
  bool isDiscontinuity(const PixelPlane& plane, const DisparityImage& image) const;
  void join(int a, int b);
  void mergeAll();
  void fitInnerCells(const QuadTree& tree);
  int root(int i);
  void append(int node, int neighbour);
  void pushEdge(int a, int b);
  void contract(int a, int b);

  MergeParams params_;
  std::vector<Node> nodes_;  // one for each leaf, later for each region
  std::vector<Link> links_;
  std::vector<std::uint32_t> mark_;  // indexed by node: the last contraction that met it
  std::uint32_t contractions_ = 0;
  EdgeQueue queue_;
  std::vector<Region> regions_;
  std::vector<PlaneMoments> inner_;  // moments of each region without its border
  std::vector<std::int32_t> region_of_leaf_;
};

}  // namespace facetloc::internal
