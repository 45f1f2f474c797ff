// SPDX-License-Identifier: BSD-3-Clause
#include "depth_triangulation.h"

#include "base/lanes.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace facetloc::internal {
namespace {

using Vertex = DepthTriangulation::Vertex;

constexpr double kFillPixels = 20;  // area from which a poorly filled triangle is refined [px at 320x240]
constexpr double kMinFillPixels =
    7;  // with this number of valid pixels, one behind the middle one is no vertex

std::int64_t orientation(const Vertex& a, const Vertex& b, const Vertex& c) {
  return std::int64_t(b.u - a.u) * (c.v - a.v) - std::int64_t(b.v - a.v) * (c.u - a.u);
}

// True if d lies strictly inside the circle through a, b, c (of positive orientation). Exact up to 16000 px.
bool inCircle(const Vertex& a, const Vertex& b, const Vertex& c, const Vertex& d) {
  const std::int64_t ax = a.u - d.u, ay = a.v - d.v, bx = b.u - d.u, by = b.v - d.v, cx = c.u - d.u,
                     cy = c.v - d.v;
  const std::int64_t aa = ax * ax + ay * ay, bb = bx * bx + by * by, cc = cx * cx + cy * cy;
  return aa * (bx * cy - by * cx) - bb * (ax * cy - ay * cx) + cc * (ax * by - ay * bx) > 0;
}

struct ScanResult {
  std::int32_t num_pixels, num_valid;
  float max_deviation;  // |d - plane| of the valid pixels
  std::int32_t row;     // the first pixel of the row where that is, of equal ones the first row; -1 = nowhere
};

// Deviations and where they are, as numbers: the larger deviation is the larger one, then the smaller index.
constexpr std::uint64_t keyOf(std::uint64_t deviation_bits, std::int32_t index) {
  return deviation_bits << 32 | static_cast<std::uint32_t>(~index);
}
constexpr std::int32_t indexOf(std::uint64_t key) { return ~static_cast<std::int32_t>(key); }

// Counts the valid pixels of a vector and keeps, lane by lane, the bits of their largest deviation from
// the prediction of a plane; non-negative floats order like integers.
FACETLOC_ALWAYS_INLINE void lookAt(const Floats& d, const Floats& expected, const Ints& is_valid,
                                   Ints& largest, Ints& num_valid) {
  const Ints bits = (Ints)(d - expected) & is_valid & 0x7fffffff;
  largest = bits > largest ? bits : largest;
  num_valid -= is_valid;
}

FACETLOC_MULTIVERSION ScanResult scanPixels(const DisparityImage& image, TriangleRows rows,
                                            const PixelPlane& plane) {
  const float* const begin = image.d.data();
  const float* const end = begin + image.d.size();
  const float slope = static_cast<float>(plane.a);
  ScanResult r{0, 0, 0, -1};
  Ints largest{}, in_row{}, valid{};  // lane by lane: the largest deviation, where the row begins that has it
  for (; !rows.done(); rows.next()) {
    const std::int32_t length = rows.last() - rows.first() + 1;
    if (length <= 0) continue;
    r.num_pixels += length;
    const std::int32_t first = rows.v() * image.camera.width + rows.first();
    const float* const pixels = begin + first;
    const float start = static_cast<float>(plane.at(rows.first(), rows.v()));
    Floats d, offset = kLaneOffset;
    Ints of_row = largest;
    std::int32_t k = 0;
    for (; k + kLanes <= length; k += kLanes, offset += static_cast<float>(kLanes)) {
      std::memcpy(&d, pixels + k, sizeof d);
      lookAt(d, start + slope * offset, d > 0, of_row, valid);
    }
    load(pixels + k, end, d);
    lookAt(d, start + slope * offset, (d > 0) & (kLane < length - k), of_row, valid);
    const Ints is_larger = of_row > largest;
    in_row = is_larger ? Ints{} + first : in_row;
    largest = of_row;
  }
  std::uint64_t worst = 0;  // the larger deviation, then the earlier row
  for (int k = 0; k < kLanes; ++k) {
    r.num_valid += valid[k];
    worst = std::max(worst, keyOf(largest[k], in_row[k]));
  }
  const auto bits = static_cast<std::uint32_t>(worst >> 32);
  std::memcpy(&r.max_deviation, &bits, sizeof bits);
  if (bits != 0) r.row = indexOf(worst);
  return r;
}

// The first pixel of a part of a row, which begins there, that deviates as much as any does from the plane.
// With disparities like infinity that is no number, and any pixel will do.
std::int32_t mostDeviating(const DisparityImage& image, std::int32_t row, const PixelPlane& plane,
                           float deviation) {
  const int u = row % image.camera.width, v = row / image.camera.width;
  const float start = static_cast<float>(plane.at(u, v)), slope = static_cast<float>(plane.a);
  float offset = 0;
  const auto deviates = [&](float d) {
    return !(std::fabs(d - (start + slope * offset)) < deviation) && d > 0;
  };
  std::int32_t pixel = row;
  for (; !deviates(image.d[pixel]); ++pixel) ++offset;
  return pixel;
}

// Which of the three is x; one of them is.
int whichIs(std::int32_t x, const std::array<std::int32_t, 3>& of) { return (of[1] == x) + 2 * (of[2] == x); }

// Disparity of the valid pixel nearest to (u, v) in the maximum norm, ties row-major; 0 without a valid
// pixel.
float nearestValid(const DisparityImage& image, int u, int v) {
  const int w = image.camera.width, h = image.camera.height;
  for (int r = 0; r < std::max(w, h) + 1; ++r)
    for (int y = std::max(0, v - r); y <= std::min(h - 1, v + r); ++y) {
      const bool whole_row = y == v - r || y == v + r;
      for (int x = u - r; x <= u + r; x += whole_row || r == 0 ? 1 : 2 * r)
        if (x >= 0 && x < w && image.d[static_cast<std::size_t>(y) * w + x] > 0)
          return image.d[static_cast<std::size_t>(y) * w + x];
    }
  return 0;
}

}  // namespace

void DepthTriangulation::compute(const DisparityImage& image) {
  vertices_.clear();
  triangles_.clear();
  fresh_.clear();
  image_ = &image;
  min_split_ = scaledPixels(params_.min_area, image.camera);
  fill_pixels_ = std::max(kMinFillPixels, scaledPixels(kFillPixels, image.camera));
  const int w = image.camera.width, h = image.camera.height;
  if (w < 2 || h < 2 || std::none_of(image.d.begin(), image.d.end(), [](float d) { return d > 0; })) return;

  round_ = 1;
  beginWithCorners();
  insertGrid();
  while (!fresh_.empty()) {
    bad_.clear();
    for (const int i : fresh_) {
      Triangle& t = triangles_[i];
      fitPlane(t);
      if (isSmall(t)) continue;
      scan(t);
      if (mustSplit(t)) bad_.push_back(keyOf(bitsOf(t.max_deviation), i));
    }
    std::sort(bad_.begin(), bad_.end(), std::greater<>());
    fresh_.clear();
    ++round_;
    for (const std::uint64_t key : bad_) {
      if (static_cast<int>(vertices_.size()) >= params_.max_vertices) break;
      const int t = indexOf(key);
      if (triangles_[t].round < round_) insert(t, triangles_[t].worst_pixel);
    }
  }
  for (Triangle& t : triangles_)
    if (isSmall(t)) scan(t);
}

// The corners lie one pixel outside at the right and the bottom, so that half-open triangles cover every
// pixel once.
void DepthTriangulation::beginWithCorners() {
  const int w = image_->camera.width, h = image_->camera.height;
  const std::array<std::array<int, 2>, 4> corners{{{0, 0}, {w, 0}, {w, h}, {0, h}}};
  for (const auto& [u, v] : corners)
    vertices_.push_back({u, v, nearestValid(*image_, std::min(u, w - 1), std::min(v, h - 1))});
  addTriangle(0, 1, 2);
  addTriangle(0, 2, 3);
  triangles_[0].neighbour[2] = 1;
  triangles_[1].neighbour[0] = 0;
}

// Without it, each of the first vertices would have most of the image scanned again.
void DepthTriangulation::insertGrid() {
  constexpr int kStep = 80, kLeastColumns = 4,
                kMostColumns = 32;  // spacing [px], limited by these numbers of columns
  const int w = image_->camera.width, h = image_->camera.height,
            step = std::clamp(kStep, w / kMostColumns, w / kLeastColumns);
  if (step < 2) return;
  int t = 0;
  for (int v = step / 2; v < h; v += step)
    for (int u = step / 2; u < w; u += step) {
      const int pixel = v * w + u;
      if (!(image_->d[pixel] > 0)) continue;
      if (static_cast<int>(vertices_.size()) >= params_.max_vertices) return;
      t = locate(u, v, t);
      insert(t, pixel);
    }
}

int DepthTriangulation::addTriangle(int a, int b, int c) {
  Triangle t;
  t.vertex = {a, b, c};
  triangles_.push_back(t);
  const int index = static_cast<int>(triangles_.size()) - 1;
  touch(index);
  return index;
}

void DepthTriangulation::touch(int t) {
  if (triangles_[t].round == round_) return;
  triangles_[t].round = round_;
  fresh_.push_back(t);
}

void DepthTriangulation::fitPlane(Triangle& t) const {
  const Vertex &A = vertices_[t.vertex[0]], &B = vertices_[t.vertex[1]], &C = vertices_[t.vertex[2]];
  const double det = static_cast<double>(orientation(A, B, C));
  const double bu = B.u - A.u, bv = B.v - A.v, bd = B.d - A.d, cu = C.u - A.u, cv = C.v - A.v, cd = C.d - A.d;
  t.plane.a = (bd * cv - cd * bv) / det;
  t.plane.b = (bu * cd - cu * bd) / det;
  t.plane.c = A.d - t.plane.a * A.u - t.plane.b * A.v;
}

void DepthTriangulation::scan(Triangle& t) const {
  const ScanResult r = scanPixels(*image_, rows(t), t.plane);
  t.num_pixels = r.num_pixels;
  t.num_valid = r.num_valid;
  t.max_deviation = r.max_deviation;
  t.worst_row = r.row;
  t.worst_pixel = -1;
}

bool DepthTriangulation::isSmall(const Triangle& t) const {
  const std::int64_t twice_area =
      orientation(vertices_[t.vertex[0]], vertices_[t.vertex[1]], vertices_[t.vertex[2]]);
  return 0.5 * static_cast<double>(twice_area) <= min_split_;
}

bool DepthTriangulation::mustSplit(Triangle& t) const {
  const bool poorly_filled = t.num_pixels >= fill_pixels_ && t.num_valid < kMinFill * t.num_pixels;
  if (!(t.max_deviation > params_.tolerance) && !poorly_filled) return false;
  if (t.worst_row >= 0) t.worst_pixel = mostDeviating(*image_, t.worst_row, t.plane, t.max_deviation);
  if (t.worst_pixel >= 0 && !isVertex(t, t.worst_pixel)) return true;
  // Nothing deviates, but for rounding noise at a vertex; an outline may be left to find.
  if (!poorly_filled || t.num_valid < fill_pixels_) return false;
  t.worst_pixel = middlePixel(t);
  return t.worst_pixel >= 0;
}

bool DepthTriangulation::isVertex(const Triangle& t, int pixel) const {
  const int u = pixel % image_->camera.width, v = pixel / image_->camera.width;
  return std::any_of(t.vertex.begin(), t.vertex.end(),
                     [&](int k) { return vertices_[k].u == u && vertices_[k].v == v; });
}

// Half of the valid pixels lie before it: splits there follow an outline with the fewest vertices.
int DepthTriangulation::middlePixel(const Triangle& t) const {
  int before = t.num_valid / 2;
  for (TriangleRows r = rows(t); !r.done(); r.next())
    for (int u = r.first(); u <= r.last(); ++u) {
      const int pixel = r.v() * image_->camera.width + u;
      if (image_->d[pixel] > 0 && --before < 0 && !isVertex(t, pixel)) return pixel;
    }
  return -1;
}

// The triangle of a pixel, by walking there from another one.
int DepthTriangulation::locate(int u, int v, int t) const {
  const Vertex p{u, v, 0};
  for (int k = 0; k < 3;) {
    const auto& vertex = triangles_[t].vertex;
    const bool outside = orientation(vertices_[vertex[k]], vertices_[vertex[(k + 1) % 3]], p) < 0;
    if (outside) t = triangles_[t].neighbour[k];
    k = outside ? 0 : k + 1;
  }
  return t;
}

void DepthTriangulation::insert(int t, int pixel) {
  const int width = image_->camera.width;
  vertices_.push_back({pixel % width, pixel / width, image_->d[pixel]});
  const int p = static_cast<int>(vertices_.size()) - 1;
  for (int k = 0; k < 3; ++k) {
    const auto& vertex = triangles_[t].vertex;
    if (orientation(vertices_[vertex[k]], vertices_[vertex[(k + 1) % 3]], vertices_[p]) == 0)
      return splitEdge(t, k, p);
  }
  splitFace(t, p);
}

// t = (a, b, c) becomes (a, b, p), (b, c, p), (c, a, p); edge 0 of each lies opposite to p.
void DepthTriangulation::splitFace(int t, int p) {
  const auto [a, b, c] = triangles_[t].vertex;
  const auto [n0, n1, n2] = triangles_[t].neighbour;
  const int t1 = addTriangle(b, c, p), t2 = addTriangle(c, a, p);
  triangles_[t].vertex = {a, b, p};
  triangles_[t].neighbour = {n0, t1, t2};
  triangles_[t1].neighbour = {n1, t2, t};
  triangles_[t2].neighbour = {n2, t, t1};
  replaceNeighbour(n1, t, t1);
  replaceNeighbour(n2, t, t2);
  touch(t);
  for (const int i : {t, t1, t2}) legalize(i, 0);
}

// p lies on edge (a, b) of t = (a, b, c), shared with j = (b, a, d) unless at the border.
void DepthTriangulation::splitEdge(int t, int edge, int p) {
  const auto rotated = [](const std::array<std::int32_t, 3>& x, int k) {
    return std::array<std::int32_t, 3>{x[k], x[(k + 1) % 3], x[(k + 2) % 3]};
  };
  const auto [a, b, c] = rotated(triangles_[t].vertex, edge);
  const auto [j, nb, nc] = rotated(triangles_[t].neighbour, edge);
  const int t1 = addTriangle(p, b, c);
  triangles_[t].vertex = {a, p, c};
  triangles_[t].neighbour = {j, t1, nc};
  triangles_[t1].neighbour = {j, nb, t};
  replaceNeighbour(nb, t, t1);
  touch(t);
  if (j >= 0) {
    const auto& nj = triangles_[j].neighbour;
    const int m = whichIs(t, nj);
    const int d = rotated(triangles_[j].vertex, m)[2];
    const int nad = nj[(m + 1) % 3], ndb = nj[(m + 2) % 3];
    const int j1 = addTriangle(p, a, d);
    triangles_[j].vertex = {b, p, d};
    triangles_[j].neighbour = {t1, j1, ndb};
    triangles_[j1].neighbour = {t, nad, j};
    replaceNeighbour(nad, j, j1);
    triangles_[t].neighbour[0] = j1;
    touch(j);
    legalize(j, 2);
    legalize(j1, 1);
  }
  legalize(t, 2);
  legalize(t1, 1);
}

// Restores the Delaunay property across an edge of t opposite to the new vertex; recurses into the flipped
// pair.
void DepthTriangulation::legalize(int t, int edge) {
  const int j = triangles_[t].neighbour[edge];
  if (j < 0) return;
  const auto& vt = triangles_[t].vertex;
  const int a = vt[edge], b = vt[(edge + 1) % 3], p = vt[(edge + 2) % 3];
  const auto& nj = triangles_[j].neighbour;
  const int m = whichIs(t, nj);
  const int d = triangles_[j].vertex[(m + 2) % 3];
  if (!inCircle(vertices_[a], vertices_[b], vertices_[p], vertices_[d])) return;

  // t = (p, a, b), j = (b, a, d)  ->  t = (p, a, d), j = (p, d, b)
  const int n_pa = triangles_[t].neighbour[(edge + 2) % 3], n_bp = triangles_[t].neighbour[(edge + 1) % 3];
  const int n_ad = nj[(m + 1) % 3], n_db = nj[(m + 2) % 3];
  triangles_[t].vertex = {p, a, d};
  triangles_[j].vertex = {p, d, b};
  triangles_[t].neighbour = {n_pa, n_ad, j};
  triangles_[j].neighbour = {t, n_db, n_bp};
  replaceNeighbour(n_ad, j, t);
  replaceNeighbour(n_bp, t, j);
  touch(t);
  touch(j);
  legalize(t, 1);
  legalize(j, 1);
}

void DepthTriangulation::replaceNeighbour(int t, int from, int to) {
  if (t < 0) return;
  triangles_[t].neighbour[whichIs(from, triangles_[t].neighbour)] = to;
}

}  // namespace facetloc::internal
