// SPDX-License-Identifier: BSD-3-Clause
#include "models/plan_outlines.h"

#include <facetloc/mapping/floor_plan.h>

#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

/** Rectangles in the axes of a grid, with their placement in the world. */
class PlanMesh {
public:
  explicit PlanMesh(const OccupancyGrid& plan) : T_w_grid_(plan.T_w_grid()), resolution_(plan.resolution) {}

  /** An upright rectangle between two places of the plan [cells]. */
  void addWall(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double height) {
    addQuad({corner(a, 0), corner(b, 0), corner(b, height), corner(a, height)});
  }
  void addLevel(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double z) {
    addQuad(
        {corner(low, z), corner({high.x(), low.y()}, z), corner(high, z), corner({low.x(), high.y()}, z)});
  }
  pcl::PolygonMesh finish() {
    pcl::toPCLPointCloud2(vertices_, mesh_.cloud);
    return std::move(mesh_);
  }

private:
  pcl::PointXYZ corner(const Eigen::Vector2d& cells, double z) const {
    const Eigen::Vector2d p = T_w_grid_ * (resolution_ * cells);
    return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(z)};
  }
  void addQuad(const std::array<pcl::PointXYZ, 4>& corners) {
    const auto first = static_cast<pcl::index_t>(vertices_.size());
    for (const pcl::PointXYZ& p : corners) vertices_.push_back(p);
    for (const auto& [b, c] : {std::pair<pcl::index_t, pcl::index_t>{1, 2}, {2, 3}}) {
      pcl::Vertices face;
      face.vertices = {first, first + b, first + c};
      mesh_.polygons.push_back(std::move(face));
    }
  }

  Eigen::Isometry2d T_w_grid_;
  double resolution_;
  pcl::PointCloud<pcl::PointXYZ> vertices_;
  pcl::PolygonMesh mesh_;
};

/** Runs of known cells in a row: first and end column. */
std::vector<std::pair<int, int>> knownRuns(const OccupancyGrid& plan, int row) {
  std::vector<std::pair<int, int>> runs;
  for (int column = 0; column < plan.width; ++column) {
    if (plan.at(column, row) == OccupancyGrid::kUnknown) continue;
    if (!runs.empty() && runs.back().second == column)
      ++runs.back().second;
    else
      runs.emplace_back(column, column + 1);
  }
  return runs;
}

/** Calls add(low, high) for rectangles that cover the known cells [cells]: runs that are the same in rows
 * above each other are one. */
template <class Add>
void coverKnown(const OccupancyGrid& plan, const Add& add) {
  std::map<std::pair<int, int>, int> open;  // run -> its first row
  const auto close = [&](const std::pair<int, int>& run, int first, int end) {
    add(Eigen::Vector2d(run.first, first), Eigen::Vector2d(run.second, end));
  };
  for (int row = 0; row < plan.height; ++row) {
    std::map<std::pair<int, int>, int> next;
    for (const auto& run : knownRuns(plan, row)) {
      const auto known = open.find(run);
      next[run] = known == open.end() ? row : known->second;
      if (known != open.end()) open.erase(known);
    }
    for (const auto& [run, first] : open) close(run, first, row);
    open.swap(next);
  }
  for (const auto& [run, first] : open) close(run, first, plan.height);
}

double extentOf(const internal::CellOutline& outline) {
  Eigen::AlignedBox2i box;
  for (const Eigen::Vector2i& corner : outline) box.extend(corner);
  return box.sizes().cast<double>().norm();
}

}  // namespace

pcl::PolygonMesh extrude(const OccupancyGrid& plan, const FloorPlanParams& params) {
  checkRanges(params);
  PlanMesh mesh(plan);
  bool has_walls = false;
  for (const internal::CellOutline& outline : internal::outlinesOf(plan)) {
    if (plan.resolution * extentOf(outline) < params.smallest) continue;
    const internal::StraightOutline corners = internal::straightened(outline);
    for (std::size_t i = 0; i < corners.size(); ++i)
      mesh.addWall(corners[i], corners[(i + 1) % corners.size()], params.wall_height);
    has_walls = true;
  }
  if (!has_walls) return {};
  const auto addLevel = [&](double z) {
    coverKnown(plan,
               [&](const Eigen::Vector2d& low, const Eigen::Vector2d& high) { mesh.addLevel(low, high, z); });
  };
  if (params.floor) addLevel(0);
  if (params.ceiling) addLevel(params.wall_height);
  return mesh.finish();
}

FloorPlanSurface::FloorPlanSurface(OccupancyGrid plan, const FloorPlanParams& params)
    : MeshSurface(extrude(plan, params)), plan_(std::move(plan)) {}

bool FloorPlanSurface::isFree(const Eigen::Vector3d& place) const {
  const Eigen::Array2d cell = plan_.cellOf(place.head<2>()).array().floor();
  const bool is_inside = (cell >= 0).all() && cell.x() < plan_.width && cell.y() < plan_.height;
  return is_inside && plan_.isFree(static_cast<int>(cell.x()), static_cast<int>(cell.y()));
}

double FloorPlanSurface::wallStd() const { return plan_.resolution / std::sqrt(12); }

}  // namespace facetloc
