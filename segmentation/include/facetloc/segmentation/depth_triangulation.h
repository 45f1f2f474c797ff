// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>
#include <facetloc/features/plane_fit.h>
#include <facetloc/segmentation/disparity_image.h>
#include <facetloc/segmentation/triangle_rows.h>

#include <array>
#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief Split stage: when a triangle is flat enough (METHOD 3.1). */
struct DepthTriangulationParams {
  double split_tolerance = 7.0;  ///< largest deviation of a pixel from its triangle [noise std]
  double min_fill = 0.5;         ///< share of valid pixels below which a triangle is refined or dropped
  double min_fill_pixels = 20;   ///< size from which the fill rule refines, at least 7 px [px at 320x240]
  double min_split = 2;          ///< smaller triangles are not refined [px at 320x240]
  int max_vertices = 20000;      ///< safety limit; the worst triangles are refined first

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("split_tolerance", p.split_tolerance, 1.0, 1e3,
          "Largest deviation of a pixel from its triangle [noise standard deviations]; 6 to 8 do well.");
    field("min_fill", p.min_fill, 0.0, 1.0,
          "Share of valid pixels below which a triangle is refined or dropped.");
    field(
        "min_fill_pixels", p.min_fill_pixels, 1.0, 1e6,
        "Size of a triangle from which poor filling refines it [px at 320x240, scaled with the image area].");
    field("min_split", p.min_split, 0.0, 1e6,
          "Triangles up to this area are not refined [px at 320x240, scaled with the image area].");
    field("max_vertices", p.max_vertices, 4, 1000000,
          "Safety limit of the triangulation; the worst triangles are refined first.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Iterative Delaunay triangulation of a disparity image after Schmitt & Chen (METHOD 3.1).
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
    std::int32_t round = 0;  ///< in which it last changed
  };

  explicit DepthTriangulation(const DepthTriangulationParams& params = {}) : params_(params) {}
  const DepthTriangulationParams& params() const { return params_; }

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

  DepthTriangulationParams params_;
  const DisparityImage* image_ = nullptr;
  double min_split_ = 0, min_fill_pixels_ = 0;  // of the image [px]
  std::vector<Vertex> vertices_;
  std::vector<Triangle> triangles_;
  int round_ = 0;
  std::vector<std::int32_t> fresh_;  // triangles that have changed in this round
  std::vector<std::uint64_t> bad_;   // those of the last one that are to be refined: deviation, ~triangle
};

}  // namespace facetloc
