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
bool hasArea(const PointTriples& points, const Corners& corners) {
  for (const std::uint32_t corner : corners)
    if (corner >= points.size() || !points[corner].allFinite()) return false;
  const Eigen::Vector3f a = points[corners[0]];
  return (points[corners[1]] - a).cross(points[corners[2]] - a).squaredNorm() > 0;
}

/** Calls a function with the corners of each triangle of the polygons. */
template <class Function>
void forEachTriangle(const std::vector<pcl::Vertices>& polygons, const Function& function) {
  for (const pcl::Vertices& polygon : polygons)
    for (std::size_t i = 2; i < polygon.vertices.size(); ++i)
      function(Corners{static_cast<std::uint32_t>(polygon.vertices[0]),
                       static_cast<std::uint32_t>(polygon.vertices[i - 1]),
                       static_cast<std::uint32_t>(polygon.vertices[i])});
}

}  // namespace

MeshSurface::MeshSurface(const pcl::PolygonMesh& mesh) {
  const PointTriples points(mesh.cloud, kPosition);
  forEachTriangle(mesh.polygons, [&](const Corners& corners) {
    if (!hasArea(points, corners)) {
      ++left_out_;
      return;
    }
    ++triangles_;
    for (const std::uint32_t corner : corners) bounds_.extend(points[corner].cast<double>());
  });
  if (triangles_ == 0) throw std::invalid_argument("it has no triangle with an area");
  requireResolved(bounds_);
  rays_ = std::make_unique<RayCaster>();
  rays_->setTriangles(points.size(), triangles_, [&](const RayCaster::Triangles& all) {
    // A vertex that is not finite belongs to no triangle; Embree still reads it.
    for (std::size_t i = 0; i < points.size(); ++i)
      Eigen::Map<Eigen::Vector3f>(all.vertices + 3 * i) =
          points[i].allFinite() ? points[i] : Eigen::Vector3f(Eigen::Vector3f::Zero());
    std::uint32_t* next = all.corners;
    forEachTriangle(mesh.polygons, [&](const Corners& corners) {
      if (hasArea(points, corners)) next = std::copy(corners.begin(), corners.end(), next);
    });
  });
}

MeshSurface::~MeshSurface() = default;

DepthImage MeshSurface::render(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const {
  return rays_->depth(camera, T_w_c, kNearestMeasured);
}

}  // namespace facetloc
