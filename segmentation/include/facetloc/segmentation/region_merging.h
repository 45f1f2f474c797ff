// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/segmentation/depth_triangulation.h>
#include <facetloc/segmentation/edge_queue.h>

namespace facetloc {

/** \brief Merge stage: when two regions are one plane (METHOD 3.2, 3.4). */
struct RegionMergingParams {
  double merge_tolerance = 2.75;  ///< largest cost of a merge [noise std]
  double min_plane_distance =
      0.12;  ///< triangles whose plane passes nearer to the camera are discontinuities [m]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("merge_tolerance", p.merge_tolerance, 0.1, 1e3,
          "Largest residual or displacement that still merges two regions [noise standard deviations]; "
          "2.5 to 3 do well.");
    field("min_plane_distance", p.min_plane_distance, 0.0, 10.0,
          "Triangles whose plane passes nearer to the camera centre span a depth discontinuity [m].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Hierarchical clustering of triangles into planar regions after Garland, Willmott & Heckbert
 * (METHOD 3.2).
 *
 * Contracts the cheapest edge between neighbouring regions first, adds their moments, and stops at
 * merge_tolerance, which is the cut of the full binary forest at that cost. The cost is the larger of the RMS
 * residual of the union and the displacement of the smaller region, so that a large plane cannot swallow a
 * small one that is several sigma away. Deterministic: ties by index. */
class RegionMerging {
public:
  struct Region {
    PlaneMoments moments;  ///< of its valid pixels in (u, v, disparity)
    PixelPlane plane;
  };

  explicit RegionMerging(const RegionMergingParams& params = {}) : params_(params) {}
  const RegionMergingParams& params() const { return params_; }

  void compute(const DepthTriangulation& triangulation, const DisparityImage& image);

  const std::vector<Region>& regions() const { return regions_; }
  /** \brief Region of each triangle; -1 for discontinuities and poorly filled triangles. */
  const std::vector<std::int32_t>& regionOfTriangle() const { return region_of_triangle_; }

  /** \brief Cost of making one region of two [units of d]; symmetric, never negative. */
  static double cost(const PlaneMoments& a, double sse_a, const PlaneMoments& b, double sse_b);

private:
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
  void makeNodes(const DepthTriangulation& triangulation, const DisparityImage& image);
  int root(int i);
  void append(int node, int neighbour);
  void pushEdge(int a, int b);
  void contract(int a, int b);

  RegionMergingParams params_;
  std::vector<Node> nodes_;  // one for each triangle, later for each region
  std::vector<Link> links_;
  std::vector<std::uint32_t> mark_;  // by node: the last contraction that met it
  std::uint32_t contractions_ = 0;
  EdgeQueue queue_;
  std::vector<Region> regions_;
  std::vector<std::int32_t> region_of_triangle_;
};

}  // namespace facetloc
