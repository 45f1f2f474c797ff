// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/segmentation/depth_triangulation.h>

#include <algorithm>
#include <cmath>
#include <cstring>

// GCC compiles a leaf kernel once per instruction set and picks at load time. No fused multiply-add among
// them: all versions give the same bits.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__)
#define FACETLOC_MULTIVERSION __attribute__((target_clones("avx2", "default")))
#else
#define FACETLOC_MULTIVERSION
#endif

namespace facetloc {
namespace {

using Vertex = DepthTriangulation::Vertex;
using Span = DepthTriangulation::Span;

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

std::int64_t floorDiv(std::int64_t a, std::int64_t b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

struct ScanResult {
  std::int32_t max_bits;  // bits of the largest deviation: non-negative floats order like integers
  std::int32_t span;      // where it is
  std::int32_t num_valid;
};

// Largest deviation |d - plane| of the valid pixels in the spans. Integer maxima vectorise without relaxed
// float rules.
FACETLOC_MULTIVERSION ScanResult scanSpans(const float* image, int width, const Span* spans, int n, double a,
                                           double b, double c) {
  ScanResult r{0, -1, 0};
  const float slope = static_cast<float>(a);
  for (int s = 0; s < n; ++s) {
    const int first = spans[s].first, length = spans[s].last - first + 1;
    const float* row = image + static_cast<std::ptrdiff_t>(spans[s].v) * width + first;
    const float start = static_cast<float>(a * first + b * spans[s].v + c);
    std::int32_t max_bits = 0, valid = 0;
    for (int k = 0; k < length; ++k) {
      const float e = std::fabs(row[k] - (start + slope * static_cast<float>(k)));
      std::int32_t bits;
      std::memcpy(&bits, &e, sizeof bits);
      const std::int32_t is_valid = row[k] > 0.f ? -1 : 0;
      bits &= is_valid;
      valid -= is_valid;
      max_bits = bits > max_bits ? bits : max_bits;
    }
    r.num_valid += valid;
    if (max_bits > r.max_bits) r.max_bits = max_bits, r.span = s;
  }
  return r;
}

// Disparity of the valid pixel nearest to (u, v) in the maximum norm, ties row-major; 0 if there is none.
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
  queue_.clear();
  image_ = &image;
  const int w = image.camera.width, h = image.camera.height;
  if (w < 2 || h < 2 || std::none_of(image.d.begin(), image.d.end(), [](float d) { return d > 0; })) return;

  // The corners lie one pixel outside at the right and the bottom, so that half-open triangles cover every
  // pixel once.
  const std::array<std::array<int, 2>, 4> corners{{{0, 0}, {w, 0}, {w, h}, {0, h}}};
  for (const auto& [u, v] : corners)
    vertices_.push_back({u, v, nearestValid(image, std::min(u, w - 1), std::min(v, h - 1))});
  addTriangle(0, 1, 2);
  addTriangle(0, 2, 3);
  triangles_[0].neighbour[2] = 1;
  triangles_[1].neighbour[0] = 0;
  for (int t : {0, 1}) rescan(t), push(t);

  while (!queue_.empty() && static_cast<int>(vertices_.size()) < params_.max_vertices) {
    std::pop_heap(queue_.begin(), queue_.end());
    const QueueEntry worst = queue_.back();
    queue_.pop_back();
    if (triangles_[worst.triangle].version == worst.version) insert(worst.triangle);
  }
}

int DepthTriangulation::addTriangle(int a, int b, int c) {
  Triangle t;
  t.vertex = {a, b, c};
  triangles_.push_back(t);
  return static_cast<int>(triangles_.size()) - 1;
}

void DepthTriangulation::spans(const Triangle& t, std::vector<Span>& out) const {
  // A pixel (u, v) counts as (u + eps, v + eps^2): a pixel on an edge then lies on exactly one side of it.
  out.clear();
  const std::array<const Vertex*, 3> p{&vertices_[t.vertex[0]], &vertices_[t.vertex[1]],
                                       &vertices_[t.vertex[2]]};
  const auto [top, bottom] = std::minmax({p[0]->v, p[1]->v, p[2]->v});
  for (int v = top; v <= bottom; ++v) {
    std::int64_t first = 0, last = image_->camera.width - 1;
    bool inside = v < image_->camera.height;
    for (int k = 0; k < 3 && inside; ++k) {
      const Vertex &a = *p[k], &b = *p[(k + 1) % 3];
      const std::int64_t du = b.u - a.u, dv = b.v - a.v;
      // Inside: du (v - a.v) - dv (u - a.u) >= 0, strictly unless the shift moves the pixel inwards.
      const bool on_edge_is_inside = dv < 0 || (dv == 0 && du > 0);
      const std::int64_t rest = du * (v - a.v) + dv * a.u - (on_edge_is_inside ? 0 : 1);
      if (dv > 0)
        last = std::min(last, floorDiv(rest, dv));
      else if (dv < 0)
        first = std::max(first, -floorDiv(rest, -dv));
      else
        inside = rest >= 0;
    }
    if (inside && first <= last) out.push_back({v, static_cast<int>(first), static_cast<int>(last)});
  }
}

void DepthTriangulation::rescan(int index) {
  Triangle& t = triangles_[index];
  const Vertex &A = vertices_[t.vertex[0]], &B = vertices_[t.vertex[1]], &C = vertices_[t.vertex[2]];
  const double det = static_cast<double>(orientation(A, B, C));
  const double bu = B.u - A.u, bv = B.v - A.v, bd = B.d - A.d, cu = C.u - A.u, cv = C.v - A.v, cd = C.d - A.d;
  t.plane.a = (bd * cv - cd * bv) / det;
  t.plane.b = (bu * cd - cu * bd) / det;
  t.plane.c = A.d - t.plane.a * A.u - t.plane.b * A.v;

  spans(t, spans_);
  t.num_pixels = 0;
  for (const Span& s : spans_) t.num_pixels += s.last - s.first + 1;
  const int width = image_->camera.width;
  const ScanResult r = scanSpans(image_->d.data(), width, spans_.data(), static_cast<int>(spans_.size()),
                                 t.plane.a, t.plane.b, t.plane.c);
  t.num_valid = r.num_valid;
  std::memcpy(&t.max_deviation, &r.max_bits, sizeof t.max_deviation);
  t.worst_pixel = -1;
  if (r.span < 0) return;
  const Span& s = spans_[r.span];
  const float* row = image_->d.data() + static_cast<std::size_t>(s.v) * width;
  const float start = static_cast<float>(t.plane.a * s.first + t.plane.b * s.v + t.plane.c);
  const float slope = static_cast<float>(t.plane.a);
  for (int u = s.first; u <= s.last && t.worst_pixel < 0; ++u)
    if (row[u] > 0 &&
        std::fabs(row[u] - (start + slope * static_cast<float>(u - s.first))) == t.max_deviation)
      t.worst_pixel = s.v * width + u;
}

void DepthTriangulation::push(int index) {
  const Triangle& t = triangles_[index];
  if (t.worst_pixel < 0) return;
  const bool poorly_filled =
      t.num_pixels >= params_.min_fill_pixels && t.num_valid < params_.min_fill * t.num_pixels;
  if (!(t.max_deviation > params_.split_tolerance) && !poorly_filled) return;
  const int u = t.worst_pixel % image_->camera.width, v = t.worst_pixel / image_->camera.width;
  for (const int k : t.vertex)
    if (vertices_[k].u == u && vertices_[k].v == v)
      return;  // rounding noise at a vertex: nothing left to refine
  queue_.push_back({t.max_deviation, index, t.version});
  std::push_heap(queue_.begin(), queue_.end());
}

void DepthTriangulation::insert(int t) {
  const int width = image_->camera.width, pixel = triangles_[t].worst_pixel;
  vertices_.push_back({pixel % width, pixel / width, image_->d[pixel]});
  const int p = static_cast<int>(vertices_.size()) - 1;
  int on_edge = -1;
  for (int k = 0; k < 3; ++k) {
    const auto& vertex = triangles_[t].vertex;
    if (orientation(vertices_[vertex[k]], vertices_[vertex[(k + 1) % 3]], vertices_[p]) == 0) on_edge = k;
  }
  dirty_.clear();
  if (on_edge < 0)
    splitFace(t, p);
  else
    splitEdge(t, on_edge, p);
  std::sort(dirty_.begin(), dirty_.end());
  dirty_.erase(std::unique(dirty_.begin(), dirty_.end()), dirty_.end());
  for (const int i : dirty_) {
    ++triangles_[i].version;
    rescan(i);
    push(i);
  }
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
  for (const int i : {t, t1, t2}) dirty_.push_back(i);
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
  dirty_.push_back(t);
  dirty_.push_back(t1);
  if (j >= 0) {
    const auto& nj = triangles_[j].neighbour;
    const int m = static_cast<int>(std::find(nj.begin(), nj.end(), t) - nj.begin());
    const int d = rotated(triangles_[j].vertex, m)[2];
    const int nad = nj[(m + 1) % 3], ndb = nj[(m + 2) % 3];
    const int j1 = addTriangle(p, a, d);
    triangles_[j].vertex = {b, p, d};
    triangles_[j].neighbour = {t1, j1, ndb};
    triangles_[j1].neighbour = {t, nad, j};
    replaceNeighbour(nad, j, j1);
    triangles_[t].neighbour[0] = j1;
    dirty_.push_back(j);
    dirty_.push_back(j1);
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
  const int m = static_cast<int>(std::find(nj.begin(), nj.end(), t) - nj.begin());
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
  dirty_.push_back(t);
  dirty_.push_back(j);
  legalize(t, 1);
  legalize(j, 1);
}

void DepthTriangulation::replaceNeighbour(int t, int from, int to) {
  if (t < 0) return;
  for (std::int32_t& n : triangles_[t].neighbour)
    if (n == from) {
      n = to;
      return;
    }
}

}  // namespace facetloc
