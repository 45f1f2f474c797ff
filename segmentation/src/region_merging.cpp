// SPDX-License-Identifier: BSD-3-Clause
#include "region_merging.h"

#include "shared/lanes.h"

#include <algorithm>
#include <cmath>

namespace facetloc::internal {
namespace {

// Moments of the valid pixels in the rows, counted from the first row and its column; shifted afterwards,
// which leaves sums of integers exact.
FACETLOC_MULTIVERSION PlaneMoments momentsOf(const DisparityImage& image, TriangleRows rows) {
  const float* const end = image.d.data() + image.d.size();
  const std::int32_t top = rows.v(), left = rows.first();
  Doubles m{}, mu{}, mv{}, muu{}, muv{}, mvv{}, d{}, ud{}, vd{}, dd{};
  for (; !rows.done(); rows.next()) {
    const float* pixels =
        image.d.data() + static_cast<std::size_t>(rows.v()) * image.camera.width + rows.first();
    const std::int32_t length = rows.last() - rows.first() + 1;
    const double v = rows.v() - top;
    Doubles u = kDoubleOffset + static_cast<double>(rows.first() - left);
    IntQuad rest = length - kQuadLane;
    for (std::int32_t i = 0; i < length; i += kDoubleLanes) {
      FloatQuad pixel;
      load(pixels + i, end, pixel);
      const IntQuad is_valid = (pixel > 0) & (rest > 0);
      const Doubles one = __builtin_convertvector(is_valid & 1, Doubles);
      const Doubles value = __builtin_convertvector((FloatQuad)((IntQuad)pixel & is_valid), Doubles);
      const Doubles one_u = one * u, one_v = one * v;
      m += one, mu += one_u, mv += one_v;
      muu += one_u * u, muv += one_v * u, mvv += one_v * v;
      d += value, ud += value * u, vd += value * v, dd += value * value;
      u += static_cast<double>(kDoubleLanes), rest -= kDoubleLanes;
    }
  }
  PlaneMoments sum;
  sum.n = total(m), sum.u = total(mu), sum.v = total(mv), sum.d = total(d);
  sum.uu = total(muu), sum.uv = total(muv), sum.vv = total(mvv);
  sum.ud = total(ud), sum.vd = total(vd), sum.dd = total(dd);
  return sum.shifted(left, top);
}

}  // namespace

double RegionMerging::cost(const PlaneMoments& a, double sse_a, const PlaneMoments& b, double sse_b) {
  const PlaneMoments both = a + b;
  const double sse = both.fit().sse;
  const double rms = std::sqrt(sse / std::max(1.0, both.n));
  // How far the smaller region lies off the common plane; three pixels always lie on it.
  const double displacement =
      std::sqrt(std::max(0.0, sse - sse_a - sse_b) / std::max(3.0, std::min(a.n, b.n)));
  return std::max(rms, displacement);
}

void RegionMerging::compute(const DepthTriangulation& triangulation, const DisparityImage& image) {
  const auto& triangles = triangulation.triangles();
  const int n = static_cast<int>(triangles.size());
  if (nodes_.capacity() < triangles.size()) {  // with room for the next images of the camera
    const std::size_t room = triangles.size() + triangles.size() / 2;
    nodes_.reserve(room), mark_.reserve(room), region_of_triangle_.reserve(room);
    links_.reserve(3 * room);
  }
  queue_.clear(params_.tolerance);
  regions_.clear();
  region_of_triangle_.assign(n, -1);
  mark_.assign(n, 0);
  contractions_ = 0;

  makeNodes(triangulation, image);
  for (int i = 0; i < n; ++i)
    if (nodes_[i].takes_part)
      for (const int j : triangles[i].neighbour)
        if (j >= 0 && nodes_[j].takes_part) {
          append(i, j);
          if (i < j) pushEdge(i, j);
        }

  const auto is_current = [this](const EdgeQueue::Edge& e) {
    return nodes_[e.a].version == e.version_a && nodes_[e.b].version == e.version_b;
  };
  for (EdgeQueue::Edge e; queue_.pop(e, is_current);) contract(e.a, e.b);

  for (int i = 0; i < n; ++i) {
    if (!nodes_[i].takes_part) continue;
    const int r = root(i);
    if (region_of_triangle_[r] < 0) {
      region_of_triangle_[r] = static_cast<int>(regions_.size());
      regions_.push_back({nodes_[r].moments, nodes_[r].moments.fit().plane});
    }
    region_of_triangle_[i] = region_of_triangle_[r];
  }
}

void RegionMerging::makeNodes(const DepthTriangulation& triangulation, const DisparityImage& image) {
  const auto& triangles = triangulation.triangles();
  nodes_.assign(triangles.size(), {});
  links_.clear();
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const DepthTriangulation::Triangle& t = triangles[i];
    Node& node = nodes_[i];
    node.parent = static_cast<std::int32_t>(i);
    if (t.num_valid == 0 || t.num_valid < triangulation.params().min_fill * t.num_pixels) continue;
    if (t.max_deviation > triangulation.params().tolerance) continue;
    if (image.unit * t.plane.toSpace(image.camera).norm() * params_.min_plane_distance > 1) continue;
    node.takes_part = true;
    node.moments = momentsOf(image, triangulation.rows(t));
    node.sse = node.moments.fit().sse;
  }
}

int RegionMerging::root(int i) {
  while (nodes_[i].parent != i) i = nodes_[i].parent = nodes_[nodes_[i].parent].parent;
  return i;
}

void RegionMerging::pushEdge(int a, int b) {
  const double c = cost(nodes_[a].moments, nodes_[a].sse, nodes_[b].moments, nodes_[b].sse);
  if (!(c <= params_.tolerance)) return;  // costs of either side are computed anew when it changes
  queue_.push({static_cast<float>(c), a, b, nodes_[a].version, nodes_[b].version});
}

void RegionMerging::append(int node, int neighbour) {
  links_.push_back({neighbour, -1});
  const int link = static_cast<int>(links_.size()) - 1;
  Node& n = nodes_[node];
  (n.last < 0 ? n.first : links_[n.last].next) = link;
  n.last = link;
  ++n.degree;
}

void RegionMerging::contract(int a, int b) {
  if (nodes_[a].degree < nodes_[b].degree) std::swap(a, b);
  Node &to = nodes_[a], &from = nodes_[b];
  from.parent = a;
  to.moments += from.moments;
  to.sse = to.moments.fit().sse;
  ++to.version;
  ++from.version;
  // The lists, which name each other at least, become one; regions that are in both are dropped once.
  links_[to.last].next = from.first;
  mark_[a] = ++contractions_;
  int last = -1;
  to.degree = 0;
  for (int link = to.first; link >= 0; link = links_[link].next) {
    const int i = root(links_[link].node);
    if (mark_[i] == contractions_) continue;
    mark_[i] = contractions_;
    links_[link].node = i;
    (last < 0 ? to.first : links_[last].next) = link;
    last = link;
    ++to.degree;
    pushEdge(a, i);
  }
  to.last = last;
  if (last < 0)
    to.first = -1;
  else
    links_[last].next = -1;
}

}  // namespace facetloc::internal
