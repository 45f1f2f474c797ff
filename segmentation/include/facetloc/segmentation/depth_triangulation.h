// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>
#include <facetloc/features/plane_fit.h>
#include <facetloc/segmentation/disparity_image.h>

#include <array>
#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief Split stage: when a triangle is flat enough (METHOD 3.1). */
struct DepthTriangulationParams {
  double split_tolerance = 7.0;  ///< largest deviation of a pixel from its triangle [noise std]
  double min_fill = 0.5;         ///< share of valid pixels below which a triangle is refined or dropped
  int min_fill_pixels = 20;      ///< size from which the fill rule refines [px]
  int max_vertices = 20000;      ///< safety limit; the worst triangles are refined first

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("split_tolerance", p.split_tolerance, 1.0, 1e3,
          "Largest deviation of a pixel from its triangle [noise standard deviations] (METHOD 3.4: 6-8).");
    field("min_fill", p.min_fill, 0.0, 1.0,
          "Share of valid pixels below which a triangle is refined or dropped.");
    field("min_fill_pixels", p.min_fill_pixels, 1, 1000000,
          "Size of a triangle from which poor filling refines it [px].");
    field("max_vertices", p.max_vertices, 4, 1000000,
          "Safety limit of the triangulation; the worst triangles are refined first.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Iterative Delaunay triangulation of a disparity image after Schmitt & Chen (METHOD 3.1).
 *
 * Starts with the image's four corners and inserts the pixel that deviates most from its triangle until all
 * triangles are within tolerance. Exact integer predicates: the result is a Delaunay triangulation of its
 * vertices, the same on every machine. Images up to 16000 px wide and high. */
class DepthTriangulation {
public:
  struct Vertex {
    std::int32_t u = 0, v = 0;  ///< [px]
    float d = 0;                ///< disparity; of the nearest valid pixel at a corner without one
  };
  struct Triangle {
    std::array<std::int32_t, 3> vertex{};  ///< counter-clockwise in (u right, v up), clockwise on screen
    std::array<std::int32_t, 3> neighbour{
        -1, -1, -1};                ///< across the edge from vertex[k] to vertex[k + 1]; -1 = border
    PixelPlane plane;               ///< through the three vertices
    float max_deviation = 0;        ///< over its valid pixels
    std::int32_t worst_pixel = -1;  ///< where that is, row-major
    std::int32_t num_pixels = 0;    ///< pixels of the triangle; every image pixel has one triangle
    std::int32_t num_valid = 0;
    std::uint32_t version = 0;
  };
  /** \brief A row of pixels inside a triangle: [first, last] of row v. */
  struct Span {
    std::int32_t v, first, last;
  };

  explicit DepthTriangulation(const DepthTriangulationParams& params = {}) : params_(params) {}
  const DepthTriangulationParams& params() const { return params_; }

  /** \brief Triangulates; the image must outlive the use of this object's results. An image without a valid
   * pixel, or smaller than 2x2, gives no triangle. */
  void compute(const DisparityImage& image);

  const std::vector<Vertex>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /** \brief The pixels of a triangle, row by row. Spans of all triangles partition the image. */
  void spans(const Triangle& t, std::vector<Span>& out) const;

private:
  struct QueueEntry {
    float deviation;
    std::int32_t triangle;
    std::uint32_t version;
    bool operator<(const QueueEntry& o) const {  // largest deviation on top, ties by the smaller index
      return deviation < o.deviation || (deviation == o.deviation && triangle > o.triangle);
    }
  };
  int addTriangle(int a, int b, int c);
  void rescan(int t);
  void push(int t);
  void insert(int t);
  void splitFace(int t, int p);
  void splitEdge(int t, int edge, int p);
  void legalize(int t, int edge);
  void replaceNeighbour(int t, int from, int to);

  DepthTriangulationParams params_;
  const DisparityImage* image_ = nullptr;
  std::vector<Vertex> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<QueueEntry> queue_;    // a heap
  std::vector<std::int32_t> dirty_;  // triangles changed by the current insertion
  std::vector<Span> spans_;
};

}  // namespace facetloc
