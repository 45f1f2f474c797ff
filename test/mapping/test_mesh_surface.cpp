// SPDX-License-Identifier: BSD-3-Clause
#include "models/model_points.h"

#include <facetloc/features/pose.h>
#include <facetloc/mapping/mesh_surface.h>

#include <gtest/gtest.h>
#include <pcl/PolygonMesh.h>
#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace facetloc {
namespace {

pcl::PolygonMesh meshOf(const std::vector<Eigen::Vector3f>& vertices,
                        const std::vector<std::vector<std::uint32_t>>& polygons) {
  pcl::PointCloud<pcl::PointXYZ> points;
  for (const Eigen::Vector3f& v : vertices) points.emplace_back(v.x(), v.y(), v.z());
  pcl::PolygonMesh mesh;
  pcl::toPCLPointCloud2(points, mesh.cloud);
  for (const auto& polygon : polygons) {
    mesh.polygons.emplace_back();
    for (const std::uint32_t corner : polygon)
      mesh.polygons.back().vertices.push_back(static_cast<pcl::index_t>(corner));
  }
  return mesh;
}

/** A box around the origin, of quadrangles. */
pcl::PolygonMesh boxOf(float x, float y, float z) {
  std::vector<Eigen::Vector3f> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z);
  return meshOf(corners,
                {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}});
}

const Intrinsics kCamera{80, 60, 66, 66, 39.5, 29.5};

TEST(MeshSurface, RendersTheDepthsOfABox) {
  const Eigen::Vector3d half(2, 3, 1.5);
  const MeshSurface box(boxOf(2, 3, 1.5f));
  EXPECT_EQ(12u, box.triangles());
  EXPECT_TRUE(box.bounds().isApprox(Eigen::AlignedBox3d(-half, half)));
  const Eigen::Isometry3d T_w_c =
      Eigen::Translation3d(0.4, -0.7, 0.2) * Eigen::Isometry3d(expSO3({0.3, -0.8, 0.2}));
  const DepthImage image = box.render(kCamera, T_w_c);
  ASSERT_TRUE(image.valid());
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 0; u < kCamera.width; ++u) {
      // The nearest of the planes that the ray meets from inside.
      const Eigen::Vector3d ray = T_w_c.linear() * kCamera.ray(u, v);
      double nearest = std::numeric_limits<double>::infinity();
      for (int axis = 0; axis < 3; ++axis)
        nearest =
            std::min(nearest, ((ray[axis] > 0 ? half : -half)[axis] - T_w_c.translation()[axis]) / ray[axis]);
      ASSERT_NEAR(nearest, image.at(u, v), 1e-5) << u << ", " << v;
    }
}

TEST(MeshSurface, LeavesHolesOpen) {
  // A wall at a depth of 2 m, of which the right half is missing.
  const MeshSurface wall(meshOf({{-5, -5, 2}, {0, -5, 2}, {0, 5, 2}, {-5, 5, 2}}, {{0, 1, 2, 3}}));
  const DepthImage image = wall.render(kCamera, Eigen::Isometry3d::Identity());
  for (int u = 0; u < kCamera.width; ++u) EXPECT_EQ(u < 40 ? 2.0f : 0.0f, image.at(u, 30)) << u;
}

TEST(MeshSurface, LeavesOutInvalidTriangles) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Eigen::Vector3f> vertices{{-5, -5, 2}, {5, -5, 2}, {0, 5, 2}, {kNaN, 0, 1}, {0, 0, 2}};
  const MeshSurface wall(
      meshOf(vertices, {{0, 1, 2}, {0, 1, 3}, {0, 1, 1}, {0, 1, 77}, {2, 1, 0xffffffff}, {0, 1}, {}}));
  EXPECT_EQ(1u, wall.triangles());
  EXPECT_EQ(4u, wall.leftOut());
  EXPECT_EQ(2.0f, wall.render(kCamera, Eigen::Isometry3d::Identity()).at(40, 30));
}

using Corners = std::vector<Eigen::Vector3f>;

/** Twice the area, along the normal. */
Eigen::Vector3d areaOf(const Corners& polygon) {
  Eigen::Vector3d area = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < polygon.size(); ++i)
    area += polygon[i].cast<double>().cross(polygon[(i + 1) % polygon.size()].cast<double>());
  return area;
}

/** Checks that triangles cover a polygon once: they have its area, and all of them its direction of rotation.
 * From each first corner, in either direction, and turned in space. */
void expectCovered(const Corners& in_plane, const char* name) {
  const Eigen::Matrix3f turn = expSO3({0.4, -1.1, 0.7}).cast<float>();
  for (const bool turned : {false, true})
    for (const bool reversed : {false, true}) {
      Corners polygon = in_plane;
      if (reversed) std::reverse(polygon.begin(), polygon.end());
      if (turned)
        for (Eigen::Vector3f& corner : polygon) corner = turn * corner + Eigen::Vector3f(30, -20, 5);
      for (std::size_t first = 0; first < polygon.size(); ++first) {
        const Eigen::Vector3d whole = areaOf(polygon);
        double sum = 0;
        for (const auto& [a, b, c] : internal::polygonTriangles(polygon)) {
          const double part = areaOf({polygon[a], polygon[b], polygon[c]}).dot(whole.normalized());
          EXPECT_GT(part, -1e-3) << name << " from corner " << first << " leaves the polygon";
          sum += std::abs(part);
        }
        EXPECT_NEAR(sum, whole.norm(), 3e-3) << name << " from corner " << first;
        std::rotate(polygon.begin(), polygon.begin() + 1, polygon.end());
      }
    }
}

TEST(MeshSurface, ConcavePolygonsAreCoveredOnce) {
  expectCovered({{6, 0, 0}, {6, 2.5f, 0}, {2.5f, 2.5f, 0}, {2.5f, 6, 0}, {0, 6, 0}, {0, 0, 0}}, "an L");
  expectCovered({{6, 0, 0},
                 {6, 1, 0},
                 {6, 2.5f, 0},
                 {4, 2.5f, 0},
                 {2.5f, 2.5f, 0},
                 {2.5f, 2.5f, 0},
                 {2.5f, 6, 0},
                 {0, 6, 0},
                 {0, 3, 0},
                 {0, 2, 0},
                 {0, 0, 0},
                 {3, 0, 0}},
                "an L with collinear and repeated corners");
  Corners star;
  for (int i = 0; i < 10; ++i) {
    const float radius = i % 2 ? 1.0f : 3.0f, angle = static_cast<float>(i * 36 * kDegree);
    star.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0f);
  }
  expectCovered(star, "a star");
  expectCovered({{0, 0, 0},
                 {9, 0, 0},
                 {9, 9, 0},
                 {0, 9, 0},
                 {0, 0, 0},
                 {3, 3, 0},
                 {3, 6, 0},
                 {6, 6, 0},
                 {6, 3, 0},
                 {3, 3, 0}},
                "a square with a hole");
  expectCovered({{0, 0, 0}, {4, 0, 0}, {8, 0, 0}, {4, 0, 0}, {4, 3, 0}, {2, 1, 0}, {0, 3, 0}},
                "a polygon with a spike");
}

TEST(MeshSurface, OtherPolygonsAreFans) {
  using Triangles = std::vector<std::array<std::uint32_t, 3>>;
  EXPECT_EQ(internal::polygonTriangles({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}),
            (Triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}))
      << "convex";
  EXPECT_EQ(internal::polygonTriangles({{0, 0, 0}, {3, 2, 0}, {3, 0, 0}, {0, 1, 0}}),
            (Triangles{{0, 1, 2}, {0, 2, 3}}))
      << "crosses itself";
  EXPECT_EQ(internal::polygonTriangles({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}),
            (Triangles{{0, 1, 2}, {0, 2, 3}}))
      << "without an area";
  EXPECT_TRUE(internal::polygonTriangles({{0, 0, 0}, {1, 0, 0}}).empty());
}

TEST(MeshSurface, AFloorOfOnePolygonEndsAtItsEdges) {
  const MeshSurface floor(
      meshOf({{3, -1, 2}, {3, 0, 2}, {0, 0, 2}, {0, 3, 2}, {-1, 3, 2}, {-1, -1, 2}}, {{0, 1, 2, 3, 4, 5}}));
  EXPECT_EQ(4u, floor.triangles());
  const auto depthAt = [&](double x, double y) {
    return floor.render({1, 1, 1, 1, 0, 0}, Eigen::Isometry3d(Eigen::Translation3d(x, y, 0))).at(0, 0);
  };
  for (const auto& [x, y] : {std::pair(2.5, -0.5), {-0.5, 2.5}, {-0.5, -0.5}}) EXPECT_EQ(2.0f, depthAt(x, y));
  for (const auto& [x, y] : {std::pair(0.5, 0.5), {1.0, 1.0}, {2.5, 0.2}}) EXPECT_EQ(0.0f, depthAt(x, y));
}

TEST(MeshSurface, RefusesMeshesWithoutSurface) {
  EXPECT_THROW(MeshSurface{pcl::PolygonMesh()}, std::invalid_argument);
  EXPECT_THROW(MeshSurface(meshOf({{0, 0, 1}, {1, 0, 1}, {2, 0, 1}}, {{0, 1, 2}})), std::invalid_argument);
  // Coordinates of a country.
  EXPECT_THROW(
      MeshSurface(meshOf({{5e5f, 5e6f, 1}, {5e5f + 10, 5e6f, 1}, {5e5f, 5e6f + 10, 1}}, {{0, 1, 2}})),
      std::invalid_argument);
  pcl::PolygonMesh torn = boxOf(1, 1, 1);
  torn.cloud.data.resize(torn.cloud.data.size() / 2);
  EXPECT_THROW(MeshSurface{torn}, std::invalid_argument);
}

}  // namespace
}  // namespace facetloc
