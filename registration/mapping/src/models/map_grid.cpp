// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/map_parts.h>
#include <facetloc/features/pose.h>
#include <facetloc/mapping/floor_plan.h>

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <optional>
#include <stdexcept>
#include <vector>

namespace facetloc {
namespace {

constexpr double kUpright = 10 * kDegree;  // deviation of a wall from the vertical
constexpr double kLevel = 10 * kDegree;    // deviation of a floor from the horizontal
constexpr double kMostCells = 1 << 26;
constexpr int kRays = 2;       // every second pixel of a picture, along rows and columns
constexpr double kErrors = 3;  // standard deviations that a point may be off its segment, or a ray too long
constexpr double kOnPlane = 0.02;  // distance from a segment's plane [m]

/** A level segment, seen from above. */
struct Level {
  double height, area;
};

void addLevelsBelow(const View& view, const Eigen::Isometry3d& T_w_m, std::vector<Level>& levels) {
  for (const Segment& s : view.segments) {
    const Segment placed = transformed(s, T_w_m);
    // Normals point away from the camera.
    if (-placed.normal().z() > std::cos(kLevel)) levels.push_back({placed.t.z(), placed.area()});
  }
}

/** The lowest height about which a tenth of all that is level lies. Throws std::runtime_error if nothing is.
 */
double lowestOf(std::vector<Level> levels) {
  constexpr double kSame = 0.05, kShare = 0.1;
  std::sort(levels.begin(), levels.end(), [](const Level& a, const Level& b) { return a.height < b.height; });
  double all = 0, near = 0;
  for (const Level& level : levels) all += level.area;
  for (std::size_t first = 0, end = 0; first < levels.size(); near -= levels[first++].area) {
    for (; end < levels.size() && levels[end].height <= levels[first].height + 2 * kSame; ++end)
      near += levels[end].area;
    if (near >= kShare * all) return levels[first].height + kSame;
  }
  throw std::runtime_error(
      "nothing tells where the floor is: the camera's mounting is unknown, and no segment is level");
}

/** How many views have seen something in a cell, and how many have seen through it. */
class Votes {
public:
  Votes(const Eigen::AlignedBox2d& bounds, double resolution) : resolution_(resolution) {
    const Eigen::Vector2d first = (bounds.min() / resolution).array().floor() - 1;
    const Eigen::Vector2d size = (bounds.max() / resolution).array().ceil() + 1 - first.array();
    if (!(size.prod() <= kMostCells))
      throw std::runtime_error(
          fmt::format("the map is {:.0f} x {:.0f} m large, which is more than {:.0f} million cells of {} m: "
                      "give a coarser resolution",
                      bounds.sizes().x(), bounds.sizes().y(), kMostCells / 1e6, resolution));
    grid_ = OccupancyGrid::filled(static_cast<int>(size.x()), static_cast<int>(size.y()), resolution,
                                  resolution * first, OccupancyGrid::kUnknown);
    cells_.resize(grid_.cells.size());
  }

  void beginView() { ++view_; }
  void hit(const Eigen::Vector2d& p) {
    if (Cell* cell = cellAt(p); cell && cell->last_hit != view_) cell->last_hit = view_, ++cell->hits;
  }
  /** \brief Cells that a view has hit were not seen through by it. All hits of a view come first. */
  void pass(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    const int steps = 1 + static_cast<int>(2 * (to - from).norm() / resolution_);
    for (int i = 0; i <= steps; ++i)
      if (Cell* cell = cellAt(from + static_cast<double>(i) / steps * (to - from));
          cell && cell->last_hit != view_ && cell->last_pass != view_)
        cell->last_pass = view_, ++cell->passes;
  }
  OccupancyGrid finish() {
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const Cell& cell = cells_[i];
      if (cell.hits + cell.passes > 0)
        grid_.cells[i] = cell.hits >= cell.passes ? OccupancyGrid::kOccupied : OccupancyGrid::kFree;
    }
    return std::move(grid_);
  }

private:
  struct Cell {
    int hits = 0, passes = 0, last_hit = 0, last_pass = 0;
  };
  Cell* cellAt(const Eigen::Vector2d& p) {
    const Eigen::Vector2d cell = (p - grid_.origin) / resolution_;
    const int column = static_cast<int>(std::floor(cell.x())), row = static_cast<int>(std::floor(cell.y()));
    return grid_.contains(column, row) ? &cells_[grid_.index(column, row)] : nullptr;
  }

  double resolution_;
  OccupancyGrid grid_;
  std::vector<Cell> cells_;
  int view_ = 0;
};

/** A view and where it stands. */
struct PlacedView {
  const View& view;
  Eigen::Isometry3d T_w_m;
  double lowest, highest;  // band of heights in the world

  /** Calls the function with the point, in the camera's frame, of each ray that has a depth. */
  template <class What>
  void forEachPoint(const What& what) const {
    const Intrinsics& k = view.depth.camera;
    for (int v = 0; v < k.height; v += kRays)
      for (int u = 0; u < k.width; u += kRays) {
        const auto inverse = view.depth.inverse_depth[static_cast<std::size_t>(v) * k.width + u];
        if (inverse > 0) what(Eigen::Vector3d(k.ray(u, v) / (inverse * DepthPicture::kQuantum)));
      }
  }
  bool isInBand(const Eigen::Vector3d& p_w) const { return p_w.z() >= lowest && p_w.z() <= highest; }
};

/** Is a point of a view on one of its upright segments? */
bool isOnWall(const View& view, const std::vector<const Segment*>& walls, const Eigen::Vector3d& p) {
  const double error = kOnPlane + kErrors * view.depth.noise.ofDepth(p.z());
  return std::any_of(walls.begin(), walls.end(), [&](const Segment* s) {
    if (std::abs(s->normal().dot(p - s->t)) > error) return false;
    const Eigen::Vector3d in_plane = s->R.transpose() * (p - s->t);
    return s->hull.contains(in_plane.head<2>().cast<float>(), static_cast<float>(kOnPlane));
  });
}

void addHits(const PlacedView& placed, Votes& votes) {
  std::vector<const Segment*> walls;
  for (const Segment& s : placed.view.segments)
    if (std::abs((placed.T_w_m.linear() * s.normal()).z()) < std::sin(kUpright)) walls.push_back(&s);
  placed.forEachPoint([&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d p_w = placed.T_w_m * p;
    if (placed.isInBand(p_w) && isOnWall(placed.view, walls, p)) votes.hit(p_w.head<2>());
  });
}

/** The part of each ray that lies within the band, but for the error of its end. */
void addPasses(const PlacedView& placed, double resolution, Votes& votes) {
  const Eigen::Vector3d eye = placed.T_w_m.translation();
  placed.forEachPoint([&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d way = placed.T_w_m.linear() * p;
    const double shorter = (resolution + kErrors * placed.view.depth.noise.ofDepth(p.z())) / p.norm();
    double from = 0, to = 1 - shorter;
    if (way.z() != 0) {
      const double a = (placed.lowest - eye.z()) / way.z(), b = (placed.highest - eye.z()) / way.z();
      from = std::max(from, std::min(a, b)), to = std::min(to, std::max(a, b));
    } else if (!placed.isInBand(eye)) {
      return;
    }
    if (from < to) votes.pass((eye + from * way).head<2>(), (eye + to * way).head<2>());
  });
}

/** The local models that can tell something. */
std::vector<int> usableModels(const Map& map) {
  const int part = mainPart(map);
  std::vector<int> found;
  for (std::size_t i = 0; i < map.models.size(); ++i)
    if (map.models[i].T_w_m && map.models[i].part == part && map.models[i].hasPicture())
      found.push_back(static_cast<int>(i));
  if (found.empty()) throw std::runtime_error("no local model has both a pose and a depth picture");
  return found;
}

}  // namespace

OccupancyGrid gridOf(const Map& map, const MapGridParams& params) {
  checkRanges(params);
  if (!(params.lowest < params.highest))
    throw std::invalid_argument("the lowest height of an occupancy grid must be below the highest");
  const std::vector<int> models = usableModels(map);
  const std::optional<CameraMounting>& mounting = map.camera.mounting;
  std::vector<Level> levels;  // if the mounting does not tell the floor
  Eigen::AlignedBox2d bounds;
  for (const int i : models) {
    const Eigen::Isometry3d& T_w_m = *map.models[static_cast<std::size_t>(i)].T_w_m;
    const std::shared_ptr<const View> view = map.view(i);
    if (!mounting) addLevelsBelow(*view, T_w_m, levels);
    bounds.extend(T_w_m.translation().head<2>());
    PlacedView{*view, T_w_m, 0, 0}.forEachPoint(
        [&](const Eigen::Vector3d& p) { bounds.extend((T_w_m * p).head<2>()); });
  }
  const double lowest = mounting ? 0 : lowestOf(std::move(levels));
  Votes votes(bounds, params.resolution);
  for (const int i : models) {
    const Eigen::Isometry3d& T_w_m = *map.models[static_cast<std::size_t>(i)].T_w_m;
    const std::shared_ptr<const View> view = map.view(i);
    const double height = mounting ? (T_w_m * mounting->T_b_c().inverse()).translation().z() : lowest;
    const PlacedView placed{*view, T_w_m, height + params.lowest, height + params.highest};
    votes.beginView();
    addHits(placed, votes);
    addPasses(placed, params.resolution, votes);
  }
  return votes.finish();
}

}  // namespace facetloc
