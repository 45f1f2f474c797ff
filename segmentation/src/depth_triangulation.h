// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "disparity_image.h"
#include "triangle_rows.h"

#include <facetloc/features/plane_fit.h>
#include <facetloc/segmentation/plane_segmenter.h>

#include <array>
#include <cstdint>
#include <vector>

namespace facetloc::internal {

/** \brief Iterative Delaunay triangulation of a disparity image after Schmitt & Chen (METHOD 3).
 *
 * Starts with a coarse grid and goes on in rounds: of each triangle beyond tolerance, the worst one first, it
 * inserts the pixel that deviates most, until all triangles are within tolerance or too small to refine. A
 * round scans the pixels of a changed triangle once, however many insertions have changed it. Exact integer
 * predicates: the result is a Delaunay triangulation of its vertices, the same on every machine. Images up to
 * 16000 px wide and high. */
class DepthTriangulation {
public:
  using Vertex = TriangleVertex;
  struct Triangle {
    std::array<std::int32_t, 3> vertex{};  ///< counter-clockwise in (u right, v up), clockwise on screen
    std::array<std::int32_t, 3> neighbour{
        -1, -1, -1};                ///< across the edge from vertex[k] to vertex[k + 1]; -1 = border
    PixelPlane plane;               ///< through the three vertices
    float max_deviation = 0;        ///< over its valid pixels
    std::int32_t worst_row = -1;    ///< the first pixel of the row where that is, or -1 if nothing deviates
    std::int32_t worst_pixel = -1;  ///< where it is to be refined, or -1; row-major
    std::int32_t num_pixels = 0;    ///< pixels of the triangle; every image pixel has one triangle
    std::int32_t num_valid = 0;
    std::int32_t round = 0;  ///< round of its last change
  };

  explicit DepthTriangulation(const SplitParams& params = {}) : params_(params) {}
  const SplitParams& params() const { return params_; }

  /** \brief Triangulates; the image must outlive the use of this object's results. An image without a valid
   * pixel, or smaller than 2x2, gives no triangle. */
  void compute(const DisparityImage& image);

  const std::vector<Vertex>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /** \brief The pixels of a triangle, row by row. Rows of all triangles partition the image. */
  TriangleRows rows(const Triangle& t) const {
    return {vertices_[t.vertex[0]], vertices_[t.vertex[1]], vertices_[t.vertex[2]]};
  }

private:
  void beginWithCorners();
  void insertGrid();
  int addTriangle(int a, int b, int c);
  void touch(int t);
  void fitPlane(Triangle& t) const;
  void scan(Triangle& t) const;
  bool isSmall(const Triangle& t) const;
  bool mustSplit(Triangle& t) const;
  bool isVertex(const Triangle& t, int pixel) const;
  int middlePixel(const Triangle& t) const;
  int locate(int u, int v, int t) const;
  void insert(int t, int pixel);
  void splitFace(int t, int p);
  void splitEdge(int t, int edge, int p);
  void legalize(int t, int edge);
  void replaceNeighbour(int t, int from, int to);

  SplitParams params_;
  const DisparityImage* image_ = nullptr;
  double min_split_ = 0, fill_pixels_ = 0;  // sizes in the image [px]
  std::vector<Vertex> vertices_;
  std::vector<Triangle> triangles_;
  int round_ = 0;
  std::vector<std::int32_t> fresh_;  // triangles that have changed in this round
  std::vector<std::uint64_t> bad_;   // those of the last one that are to be refined: deviation, ~triangle
};

}  // namespace facetloc::internal
