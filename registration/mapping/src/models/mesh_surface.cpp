// SPDX-License-Identifier: BSD-3-Clause
#include "models/model_points.h"
#include "models/ray_caster.h"

#include <facetloc/mapping/mesh_surface.h>

#include <pcl/PolygonMesh.h>

#include <algorithm>
#include <stdexcept>

namespace facetloc {

using namespace internal;

namespace {

using Corners = std::array<std::uint32_t, 3>;

/** Can these three vertices be seen? */
bool hasArea(const ModelPoints& points, const Corners& corners) {
  for (const std::uint32_t corner : corners)
    if (corner >= points.size() || !points[corner].allFinite()) return false;
  const Eigen::Vector3f a = points[corners[0]];
  return (points[corners[1]] - a).cross(points[corners[2]] - a).squaredNorm() > 0;
}

/** Triangles of the polygons, also those without an area. */
std::vector<Corners> trianglesOf(const std::vector<pcl::Vertices>& polygons, const ModelPoints& points) {
  std::vector<Corners> triangles;
  triangles.reserve(polygons.size());
  std::vector<Eigen::Vector3f> corners;
  for (const pcl::Vertices& polygon : polygons) {
    const auto at = [&](std::size_t k) { return static_cast<std::uint32_t>(polygon.vertices[k]); };
    const std::size_t n = polygon.vertices.size();
    corners.clear();
    if (n > 3)
      for (std::size_t k = 0; k < n && at(k) < points.size() && points[at(k)].allFinite(); ++k)
        corners.push_back(points[at(k)]);
    if (n > 3 && corners.size() == n)
      for (const Corners& triangle : polygonTriangles(corners))
        triangles.push_back({at(triangle[0]), at(triangle[1]), at(triangle[2])});
    else
      for (std::size_t k = 2; k < n; ++k) triangles.push_back({at(0), at(k - 1), at(k)});
  }
  return triangles;
}

/** Is this a sheet as a scan is: open, of triangles that share nearly all of their edges, and agree about
 * their front? */
bool isSheet(const std::vector<Corners>& triangles) {
  constexpr double kInner = 0.9, kOuter = 0.001;  // shares of the edges
  std::vector<std::uint64_t> edges;               // the smaller vertex, the larger one, and which comes first
  for (const Corners& corners : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = corners[k], b = corners[(k + 1) % 3];
      edges.push_back(std::min(a, b) << 33 | std::max(a, b) << 1 | (a < b ? 1 : 0));
    }
  std::sort(edges.begin(), edges.end());
  double inner = 0, outer = 0, all = 0;
  for (std::size_t first = 0, last; first < edges.size(); first = last) {
    last = first + 1;
    while (last < edges.size() && edges[last] >> 1 == edges[first] >> 1) ++last;
    ++all;
    outer += last - first == 1;
    inner += last - first == 2 && edges[first] != edges[first + 1];
  }
  return inner >= kInner * all && outer >= kOuter * all;
}

}  // namespace

MeshSurface::MeshSurface(const pcl::PolygonMesh& mesh) {
  const ModelPoints points(mesh.cloud);
  std::vector<Corners> triangles = trianglesOf(mesh.polygons, points);
  const auto end = std::remove_if(triangles.begin(), triangles.end(),
                                  [&](const Corners& corners) { return !hasArea(points, corners); });
  left_out_ = static_cast<std::size_t>(triangles.end() - end);
  triangles.erase(end, triangles.end());
  triangles_ = triangles.size();
  for (const Corners& corners : triangles)
    for (const std::uint32_t corner : corners) bounds_.extend(points[corner].cast<double>());
  if (triangles_ == 0) throw std::invalid_argument("it has no triangle with an area");
  requireResolved(bounds_);
  is_scan_ = isSheet(triangles);
  rays_ = std::make_unique<RayCaster>();
  rays_->setTriangles(points.size(), triangles_, [&](const RayCaster::Triangles& all) {
    // A vertex that is not finite belongs to no triangle; Embree still reads it.
    for (std::size_t i = 0; i < points.size(); ++i)
      Eigen::Map<Eigen::Vector3f>(all.vertices + 3 * i) =
          points[i].allFinite() ? points[i] : Eigen::Vector3f(Eigen::Vector3f::Zero());
    std::uint32_t* next = all.corners;
    for (const Corners& corners : triangles) next = std::copy(corners.begin(), corners.end(), next);
  });
}

MeshSurface::~MeshSurface() = default;

DepthImage MeshSurface::render(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const {
  return rays_->depth(camera, T_w_c, is_scan_);
}

}  // namespace facetloc
