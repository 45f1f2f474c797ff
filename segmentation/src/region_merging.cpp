// SPDX-License-Identifier: BSD-3-Clause
#include "region_merging.h"

#include "base/lanes.h"
#include "base/room.h"

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

double RegionMerging::squaredCost(const PlaneMoments& a, double sse_a, const PlaneMoments& b, double sse_b) {
  const PlaneMoments both = a + b;
  const double sse = both.fit().sse;
  const double mean_square = sse / std::max(1.0, both.n);
  // How far the smaller region lies off the common plane; three pixels always lie on it.
  const double displacement = std::max(0.0, sse - sse_a - sse_b) / std::max(3.0, std::min(a.n, b.n));
  return std::max(mean_square, displacement);
}

double RegionMerging::cost(const PlaneMoments& a, double sse_a, const PlaneMoments& b, double sse_b) {
  return std::sqrt(squaredCost(a, sse_a, b, sse_b));
}

void RegionMerging::compute(const DepthTriangulation& triangulation, const DisparityImage& image) {
  const auto& triangles = triangulation.triangles();
  const int n = static_cast<int>(triangles.size());
  begin(triangles.size());
  for (int i = 0; i < n; ++i) {
    const DepthTriangulation::Triangle& t = triangles[i];
    if (t.num_valid == 0 || t.num_valid < kMinFill * t.num_pixels) continue;
    if (t.max_deviation > triangulation.params().tolerance) continue;
    if (isDiscontinuity(t.plane, image)) continue;
    const PlaneMoments moments = momentsOf(image, triangulation.rows(t));
    addNode(i, moments, moments.fit());
  }
  for (int i = 0; i < n; ++i)
    for (const int j : triangles[i].neighbour)
      if (i < j) join(i, j);
  mergeAll();
}

void RegionMerging::compute(const QuadTree& tree, const DisparityImage& image) {
  const auto& leaves = tree.leaves();
  begin(leaves.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const PlaneMoments::Fit fit = leaves[i].moments.fit();
    if (!isDiscontinuity(fit.plane, image)) addNode(static_cast<int>(i), leaves[i].moments, fit);
  }
  tree.forEachCommonSide([this](int a, int b) { join(a, b); });
  mergeAll();
  fitInnerCells(tree);
}

// Cells at the border of a region may reach a little beyond an edge of the room, and tilt its plane; where
// the others are most of it, the plane is theirs.
void RegionMerging::fitInnerCells(const QuadTree& tree) {
  constexpr double kMost = 0.5;
  makeRoom(inner_, regions_.size());
  inner_.resize(regions_.size());
  for (std::size_t r = 0; r < regions_.size(); ++r) inner_[r] = regions_[r].moments;
  const int columns = tree.columns(), rows = tree.rows();
  const auto regionOf = [&](int cell) {
    const int leaf = tree.leafOfCell()[cell];
    return leaf < 0 ? -1 : region_of_leaf_[leaf];
  };
  for (int row = 0, cell = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column, ++cell) {
      const int r = regionOf(cell);
      if (r < 0) continue;
      if ((column > 0 && regionOf(cell - 1) != r) || (column + 1 < columns && regionOf(cell + 1) != r) ||
          (row > 0 && regionOf(cell - columns) != r) || (row + 1 < rows && regionOf(cell + columns) != r))
        inner_[r] -= tree.momentsOfCell(cell);
    }
  for (std::size_t r = 0; r < regions_.size(); ++r)
    if (inner_[r].n >= kMost * regions_[r].moments.n) regions_[r].plane = inner_[r].fit().plane;
}

void RegionMerging::begin(std::size_t leaves) {
  makeRoom(nodes_, leaves), makeRoom(mark_, leaves), makeRoom(region_of_leaf_, leaves);
  makeRoom(links_, 6 * leaves);  // leaves in the plane have fewer than six neighbours on average
  queue_.clear(params_.tolerance);
  regions_.clear();
  links_.clear();
  nodes_.assign(leaves, {});
  region_of_leaf_.assign(leaves, -1);
  mark_.assign(leaves, 0);
  contractions_ = 0;
}

void RegionMerging::addNode(int leaf, const PlaneMoments& moments, const PlaneMoments::Fit& fit) {
  Node& node = nodes_[leaf];
  node.parent = leaf;
  node.moments = moments;
  node.sse = fit.sse;
  node.takes_part = true;
}

// Does the plane pass so near to the camera that it must be a silhouette (METHOD 5.1)?
bool RegionMerging::isDiscontinuity(const PixelPlane& plane, const DisparityImage& image) const {
  return image.unit * plane.toSpace(image.camera).norm() * params_.min_plane_distance > 1;
}

void RegionMerging::join(int a, int b) {
  if (!nodes_[a].takes_part || !nodes_[b].takes_part) return;
  append(a, b);
  append(b, a);
  pushEdge(a, b);
}

void RegionMerging::mergeAll() {
  const auto is_current = [this](const EdgeQueue::Edge& e) {
    return nodes_[e.a].version == e.version_a && nodes_[e.b].version == e.version_b;
  };
  for (EdgeQueue::Edge e; queue_.pop(e, is_current);) contract(e.a, e.b);

  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (!nodes_[i].takes_part) continue;
    const int r = root(static_cast<int>(i));
    if (region_of_leaf_[r] < 0) {
      region_of_leaf_[r] = static_cast<int>(regions_.size());
      regions_.push_back({nodes_[r].moments, nodes_[r].moments.fit().plane});
    }
    region_of_leaf_[i] = region_of_leaf_[r];
  }
}

int RegionMerging::root(int i) {
  while (nodes_[i].parent != i) i = nodes_[i].parent = nodes_[nodes_[i].parent].parent;
  return i;
}

void RegionMerging::pushEdge(int a, int b) {
  const Node &x = nodes_[a], &y = nodes_[b];
  const double squared = squaredCost(x.moments, x.sse, y.moments, y.sse);
  if (!(squared <= params_.tolerance * params_.tolerance)) return;  // computed anew when either side changes
  queue_.push({static_cast<float>(std::sqrt(squared)), a, b, x.version, y.version});
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
