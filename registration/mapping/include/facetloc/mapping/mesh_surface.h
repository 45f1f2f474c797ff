// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/mapping/surface.h>

#include <cstddef>
#include <memory>

namespace pcl {
struct PCLPointCloud2;
struct PolygonMesh;
}  // namespace pcl

namespace facetloc {

namespace internal {
class RayCaster;
}

/** \brief The polygons of a mesh.
 *
 * They are seen from both of their sides, unless the mesh is a scan: open, and of triangles that share nearly
 * all of their edges and agree about their front, from which their vertices are anticlockwise. The back
 * of a scan is unknown, since no camera saw it. The mesh need not be closed, manifold or oriented.
 * Polygons may be concave; one that crosses itself is cut into triangles from its first vertex. Triangles
 * with an index beyond the vertices, a vertex that is not finite or no area are left out. */
class MeshSurface : public Surface {
public:
  /** \brief \param mesh in metres; its cloud has fields x, y, z of floats. It is not needed afterwards.
   * Throws std::invalid_argument if nothing of it can be used, or if it lies so far from its origin that
   * floats do not resolve a millimetre (10 km). */
  explicit MeshSurface(const pcl::PolygonMesh& mesh);
  ~MeshSurface() override;

  DepthImage render(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const override;
  Eigen::AlignedBox3d bounds() const override { return bounds_; }
  bool isDrawn() const override { return !is_scan_; }

  std::size_t triangles() const { return triangles_; }
  std::size_t leftOut() const { return left_out_; }  ///< triangles that cannot be used

private:
  std::unique_ptr<internal::RayCaster> rays_;
  Eigen::AlignedBox3d bounds_;
  std::size_t triangles_ = 0, left_out_ = 0;
  bool is_scan_ = false;
};

/** \brief The points of a scan, each a disc on the plane of its neighbours, with a radius of 1.5 times their
 * distance.
 *
 * Larger holes stay holes. A surface so near that two points are 0.1 rad apart is unknown: anything between
 * them would be invented. */
class CloudSurface : public Surface {
public:
  /** \brief Looks for the neighbours of each point: about 10 s for a million points and one thread.
   * \param cloud in metres, with fields x, y, z of floats. It is not needed afterwards. Points that are not
   * finite, and those that are much farther from their neighbours than these are from theirs, are left out.
   * Throws std::invalid_argument if fewer than 12 remain, or if they lie so far from the origin that floats
   * do not resolve a millimetre (10 km). \param threads 0 = all cores */
  explicit CloudSurface(const pcl::PCLPointCloud2& cloud, int threads = 1);
  ~CloudSurface() override;

  DepthImage render(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const override;
  Eigen::AlignedBox3d bounds() const override { return bounds_; }

  std::size_t points() const { return points_; }
  std::size_t leftOut() const { return left_out_; }  ///< points that are not used
  double spacing() const { return spacing_; }        ///< distance of neighbouring points, median [m]
  double residual() const {
    return residual_;
  }  ///< median distance of points from the planes of their neighbours [m]

private:
  std::unique_ptr<internal::RayCaster> rays_;
  Eigen::AlignedBox3d bounds_;
  std::size_t points_ = 0, left_out_ = 0;
  double spacing_ = 0, residual_ = 0;
};

}  // namespace facetloc
