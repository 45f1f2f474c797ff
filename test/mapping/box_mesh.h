// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <pcl/PolygonMesh.h>
#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <array>

namespace facetloc {

/** \brief A mesh of boxes along the axes. */
class BoxMesh {
public:
  BoxMesh& add(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
    const auto first = static_cast<pcl::index_t>(points_.size());
    for (int i = 0; i < 8; ++i)
      points_.emplace_back((i & 1 ? high : low).x(), (i & 2 ? high : low).y(), (i & 4 ? high : low).z());
    for (const std::array<int, 4>& side : {std::array<int, 4>{0, 1, 3, 2},
                                           {4, 5, 7, 6},
                                           {0, 1, 5, 4},
                                           {2, 3, 7, 6},
                                           {0, 2, 6, 4},
                                           {1, 3, 7, 5}}) {
      mesh_.polygons.emplace_back();
      for (const int corner : side) mesh_.polygons.back().vertices.push_back(first + corner);
    }
    return *this;
  }
  BoxMesh& turned(const Eigen::Matrix3d& R) {
    for (pcl::PointXYZ& p : points_) p.getVector3fMap() = (R.cast<float>() * p.getVector3fMap()).eval();
    return *this;
  }
  pcl::PolygonMesh mesh() const {
    pcl::PolygonMesh mesh = mesh_;
    pcl::toPCLPointCloud2(points_, mesh.cloud);
    return mesh;
  }

private:
  pcl::PointCloud<pcl::PointXYZ> points_;
  pcl::PolygonMesh mesh_;
};

/** \brief Two rooms, 6 x 4 m and 4 x 4 m, 2.5 m high, with a door between them, a table and a cabinet. The
 * floor is at z = 0, the first room from (0, 0), the second from (6.2, 0). */
inline BoxMesh twoRooms(bool ceiling = true) {
  constexpr float w = 0.2f, h = 2.5f;
  BoxMesh mesh;
  mesh.add({-w, -w, -w}, {10.4f, 4 + w, 0});
  if (ceiling) mesh.add({-w, -w, h}, {10.4f, 4 + w, h + w});
  // With a window.
  mesh.add({-w, -w, 0}, {7, 0, h})
      .add({9, -w, 0}, {10.4f, 0, h})
      .add({7, -w, 0}, {9, 0, 0.8f})
      .add({7, -w, 2}, {9, 0, h});
  mesh.add({-w, 4, 0}, {10.4f, 4 + w, h});
  mesh.add({-w, 0, 0}, {0, 4, h}).add({10.2f, 0, 0}, {10.4f, 4, h});
  mesh.add({6, 0, 0}, {6.2f, 1.5f, h}).add({6, 2.5f, 0}, {6.2f, 4, h}).add({6, 1.5f, 2}, {6.2f, 2.5f, h});
  mesh.add({1, 0.6f, 0.7f}, {2.6f, 1.4f, 0.75f})
      .add({4, 3.4f, 0}, {5, 4, 1.9f})
      .add({9, 0, 0}, {10.2f, 0.5f, 1.2f});
  return mesh;
}

}  // namespace facetloc
