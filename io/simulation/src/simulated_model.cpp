// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_place.h>

#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>

namespace facetloc {
namespace {

/** Vertices and faces that grow together. */
class MeshBuilder {
public:
  std::uint32_t add(const Eigen::Vector3d& p) {
    pcl::PointXYZ point;
    point.getVector3fMap() = p.cast<float>();
    vertices_.push_back(point);
    return static_cast<std::uint32_t>(vertices_.size() - 1);
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    pcl::Vertices face;
    for (const std::uint32_t i : {a, b, c}) face.vertices.push_back(static_cast<pcl::index_t>(i));
    mesh_.polygons.push_back(std::move(face));
  }
  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }
  pcl::PolygonMesh finish() {
    pcl::toPCLPointCloud2(vertices_, mesh_.cloud);
    return std::move(mesh_);
  }

private:
  pcl::PolygonMesh mesh_;
  pcl::PointCloud<pcl::PointXYZ> vertices_;
};

void addTo(MeshBuilder& mesh, const Rectangle& r) {
  const Eigen::Vector3d u = r.half_u * r.axis_u, v = r.half_v * r.axis_v;
  std::array<std::uint32_t, 4> corners{};
  const std::array<Eigen::Vector3d, 4> places = {r.centre - u - v, r.centre + u - v, r.centre + u + v,
                                                 r.centre - u + v};
  std::transform(places.begin(), places.end(), corners.begin(),
                 [&mesh](const Eigen::Vector3d& p) { return mesh.add(p); });
  mesh.quad(corners[0], corners[1], corners[2], corners[3]);
}

/** Rings of latitude, or the two ends of a cylinder. */
void addTo(MeshBuilder& mesh, const RoundBody& body) {
  constexpr int kSides = 24, kRings = 13;
  const bool is_cylinder = body.shape == RoundBody::Shape::cylinder;
  const int rings = is_cylinder ? 2 : kRings;
  std::vector<std::uint32_t> before;
  for (int ring = 0; ring < rings; ++ring) {
    const double latitude = 180 * kDegree * ring / (rings - 1) - 90 * kDegree;
    const double radius = is_cylinder ? 1 : std::cos(latitude);
    const double height = is_cylinder ? 2 * ring - 1 : std::sin(latitude);
    std::vector<std::uint32_t> now;
    for (int side = 0; side < kSides; ++side) {
      const double angle = 360 * kDegree * side / kSides;
      const Eigen::Vector3d unit(radius * std::cos(angle), radius * std::sin(angle), height);
      now.push_back(mesh.add(body.T_w_b * unit.cwiseProduct(body.half_size)));
    }
    for (int side = 0; ring > 0 && side < kSides; ++side) {
      const int next = (side + 1) % kSides;
      mesh.quad(before[side], before[next], now[next], now[side]);
    }
    before = std::move(now);
  }
}

bool isInside(const PlanOutline& outline, const Eigen::Vector2d& p) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    const Eigen::Vector2d along = b - a, to = p - a;
    if (along.x() * to.y() - along.y() * to.x() < 0) return false;
  }
  return true;
}

void fill(const PlanOutline& outline, std::int8_t value, OccupancyGrid& grid) {
  Eigen::AlignedBox2d bounds;
  for (const Eigen::Vector2d& p : outline) bounds.extend(grid.cellOf(p));
  const Eigen::Vector2i first = bounds.min().array().floor().cast<int>();
  const Eigen::Vector2i last = bounds.max().array().floor().cast<int>();
  for (int row = first.y(); row <= last.y(); ++row)
    for (int column = first.x(); column <= last.x(); ++column)
      if (grid.contains(column, row) && isInside(outline, grid.centre(column, row)))
        grid.cells[grid.index(column, row)] = value;
}

/** Places along all ways of the robot, closer than cells are wide. */
std::vector<Eigen::Vector2d> placesDriven(const SimulatedPlace& place, double step) {
  std::vector<Eigen::Vector2d> places;
  for (const Route* route : {&place.mapping_route, &place.query_route})
    for (std::size_t i = 0; i + (place.one_way ? 1 : 0) < route->size(); ++i) {
      const Eigen::Vector2d from = (*route)[i].place, way = (*route)[(i + 1) % route->size()].place - from;
      const int steps = 1 + static_cast<int>(way.norm() / step);
      for (int k = 0; k < steps; ++k) places.emplace_back(from + static_cast<double>(k) / steps * way);
    }
  return places;
}

/** Frees the unknown cells that can be reached from these places without crossing anything else. */
void flood(const std::vector<Eigen::Vector2d>& places, OccupancyGrid& grid) {
  std::vector<Eigen::Vector2i> reached;
  const auto reach = [&](const Eigen::Vector2i& cell) {
    if (!grid.contains(cell.x(), cell.y()) || grid.at(cell.x(), cell.y()) != OccupancyGrid::kUnknown) return;
    grid.cells[grid.index(cell.x(), cell.y())] = OccupancyGrid::kFree;
    reached.push_back(cell);
  };
  for (const Eigen::Vector2d& place : places) reach(grid.cellOf(place).array().floor().cast<int>());
  while (!reached.empty()) {
    const Eigen::Vector2i cell = reached.back();
    reached.pop_back();
    for (const auto& step : {Eigen::Vector2i(1, 0), {-1, 0}, {0, 1}, {0, -1}}) reach(cell + step);
  }
}

}  // namespace

SimulatedWorld lastingParts(const SimulatedPlace& place) {
  std::set<std::uint16_t> later;
  for (const Rectangle& r : place.later.rectangles) later.insert(r.plane_id);
  SimulatedWorld world;
  for (const Rectangle& r : place.mapped.rectangles)
    if (later.count(r.plane_id) > 0) world.rectangles.push_back(r);
  for (const RoundBody& body : place.mapped.bodies)
    if (std::any_of(place.later.bodies.begin(), place.later.bodies.end(), [&body](const RoundBody& other) {
          return body.shape == other.shape && body.half_size == other.half_size &&
                 body.T_w_b.matrix() == other.T_w_b.matrix();
        }))
      world.bodies.push_back(body);
  return world;
}

pcl::PolygonMesh meshOf(const SimulatedWorld& world) {
  MeshBuilder mesh;
  for (const Rectangle& r : world.rectangles)
    if (r.material != Material::glass) addTo(mesh, r);
  for (const RoundBody& body : world.bodies)
    if (body.material != Material::glass) addTo(mesh, body);
  return mesh.finish();
}

OccupancyGrid floorPlanOf(const SimulatedPlace& place, double resolution) {
  constexpr double kMargin = 0.5;  // width of unknown cells around the walls [m]
  if (!(resolution > 0)) throw std::invalid_argument("cells of an occupancy grid need a positive size");
  Eigen::AlignedBox2d bounds;
  for (const PlanOutline& outline : place.walls)
    for (const Eigen::Vector2d& p : outline) bounds.extend(p);
  if (bounds.isEmpty()) throw std::invalid_argument("this place has no walls for a floor plan");
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(kMargin);
  const Eigen::Vector2d origin = ((bounds.min() - margin) / resolution).array().floor() * resolution;
  const Eigen::Vector2i size = ((bounds.max() + margin - origin) / resolution).array().ceil().cast<int>();
  OccupancyGrid grid = OccupancyGrid::filled(size.x(), size.y(), resolution, origin, OccupancyGrid::kUnknown);
  const std::vector<Eigen::Vector2d> driven = placesDriven(place, resolution / 2);
  constexpr std::int8_t kShut = 50;  // while the rest is flooded
  for (const PlanOutline& doorway : place.doorways)
    if (std::none_of(driven.begin(), driven.end(),
                     [&doorway](const Eigen::Vector2d& p) { return isInside(doorway, p); }))
      fill(doorway, kShut, grid);
  for (const PlanOutline& outline : place.walls) fill(outline, OccupancyGrid::kOccupied, grid);
  flood(driven, grid);
  std::replace(grid.cells.begin(), grid.cells.end(), kShut, OccupancyGrid::kUnknown);
  return grid;
}

}  // namespace facetloc
