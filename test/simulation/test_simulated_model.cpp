// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_place.h>

#include <gmock/gmock.h>
#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <cmath>
#include <limits>

namespace facetloc {
namespace {

using Eigen::Vector3d;

/** Depth along a ray by the triangles of a mesh, one after the other (Moeller and Trumbore). */
class Triangles {
public:
  explicit Triangles(const pcl::PolygonMesh& mesh) : mesh_(mesh) {
    pcl::fromPCLPointCloud2(mesh.cloud, points_);
  }

  double alongRay(const Vector3d& origin, const Vector3d& ray) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const pcl::Vertices& face : mesh_.polygons) {
      const Vector3d a = at(face.vertices[0]), u = at(face.vertices[1]) - a, v = at(face.vertices[2]) - a;
      const Vector3d p = ray.cross(v), q = (origin - a).cross(u);
      const double determinant = u.dot(p);
      if (determinant == 0) continue;
      const double x = (origin - a).dot(p) / determinant, y = ray.dot(q) / determinant;
      const double depth = v.dot(q) / determinant;
      if (x >= 0 && y >= 0 && x + y <= 1 && depth > 0.05) nearest = std::min(nearest, depth);
    }
    return nearest;
  }

private:
  Vector3d at(pcl::index_t i) const {
    return points_[static_cast<std::size_t>(i)].getVector3fMap().cast<double>();
  }
  const pcl::PolygonMesh& mesh_;
  pcl::PointCloud<pcl::PointXYZ> points_;
};

/** Rays in the mesh meet the surfaces that a camera sees in the scene; but for round things, which have
 * edges. */
TEST(SimulatedModel, ShowsTheSurfacesOfTheCamera) {
  const SimulatedPlace place = simulatedPlace("office", 4);
  SimulatedWorld scene = lastingParts(place);
  scene.bodies.clear();
  const pcl::PolygonMesh mesh = meshOf(scene);
  const Triangles triangles(mesh);
  const Intrinsics k{32, 24, 29, 29, 15.5, 11.5};
  const SimulatedCamera camera(k, {}, 1);
  int compared = 0;
  for (const Eigen::Isometry3d& T_w_c : simulateDrive(place.mapping_route, 4, {}, 1)) {
    const DepthImage image = camera.renderExact(scene, T_w_c).depth;
    for (int v = 1; v < k.height; v += 5)
      for (int u = 1; u < k.width; u += 5) {
        const double z = triangles.alongRay(T_w_c.translation(), T_w_c.linear() * k.ray(u, v));
        EXPECT_NEAR(image.at(u, v), z, 1e-3) << u << " " << v;
        ++compared;
      }
  }
  EXPECT_GE(compared, 100);
}

TEST(SimulatedModel, HasNothingThatMoves) {
  for (const char* name : {"office", "home", "hall"}) {
    const SimulatedPlace place = simulatedPlace(name, 3);
    const SimulatedWorld scene = lastingParts(place);
    EXPECT_LT(scene.rectangles.size(), place.mapped.rectangles.size()) << name;
    EXPECT_GT(2 * scene.rectangles.size(), place.mapped.rectangles.size()) << name;
    const auto isIn = [](const Rectangle& r, const SimulatedWorld& other) {
      return std::any_of(other.rectangles.begin(), other.rectangles.end(), [&r](const Rectangle& o) {
        return o.centre == r.centre && o.axis_u == r.axis_u && o.half_u == r.half_u && o.half_v == r.half_v;
      });
    };
    for (const Rectangle& r : scene.rectangles)
      EXPECT_TRUE(isIn(r, place.mapped) && isIn(r, place.later)) << name;
  }
}

class FloorPlans : public testing::TestWithParam<std::string> {};

/** A thing that reaches from the floor to above every door, and is no shelf, is occupied in the plan. */
TEST_P(FloorPlans, AreTheWallsOfTheScene) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SimulatedPlace place = simulatedPlace(GetParam(), seed);
    const OccupancyGrid grid = floorPlanOf(place, 0.05);
    int walls = 0, upright = 0;
    for (const Rectangle& r : place.mapped.rectangles) {
      const bool is_upright = std::abs(r.normal().z()) < 1e-9 && std::abs(r.axis_v.z()) > 0.999;
      if (!is_upright || r.half_v < 1.2 || r.half_u < 0.25 || r.centre.z() > r.half_v + 0.01) continue;
      ++upright;
      bool occupied = false;
      for (const double off : {-0.04, 0.0, 0.04}) {
        const Eigen::Vector2d cell = grid.cellOf((r.centre + off * r.normal()).head<2>());
        occupied |=
            grid.isOccupied(static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y())));
      }
      walls += occupied;
    }
    EXPECT_GE(walls, 8) << GetParam() << seed;
    EXPECT_GE(walls, 0.6 * upright) << GetParam() << seed;
    // The robot never stands in a wall, nor where nothing is known.
    for (const Route* route : {&place.mapping_route, &place.query_route})
      for (const Waypoint& waypoint : *route) {
        const Eigen::Vector2d cell = grid.cellOf(waypoint.place);
        EXPECT_TRUE(
            grid.isFree(static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y()))))
            << GetParam() << seed;
      }
    EXPECT_EQ(grid.at(0, 0), OccupancyGrid::kUnknown);
  }
}

INSTANTIATE_TEST_SUITE_P(All, FloorPlans, testing::Values("office", "home", "hall", "hotel", "doors"),
                         [](const auto& place) { return place.param; });

TEST(SimulatedModel, PlacesWithoutWallsHaveNoPlan) {
  EXPECT_THROW(floorPlanOf(simulatedPlace("boards", 1)), std::invalid_argument);
  EXPECT_THROW(floorPlanOf(simulatedPlace("office", 1), 0), std::invalid_argument);
}

}  // namespace
}  // namespace facetloc
