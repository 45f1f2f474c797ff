// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera.h>
#include <facetloc/features/pose.h>
#include <facetloc/mapping/map_findings.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <vector>

namespace facetloc {
namespace {

constexpr double kSameAngle = 4 * kDegree, kSameHeight = 0.05;  // one uneven floor in two images [m]
constexpr double kWide = 3;                    // times that: where a camera in the hand has its floor, too
constexpr double kMostHeightStd = 0.01;        // over the floor, of a camera on wheels [m]
constexpr double kSteepest = 60 * kDegree;     // largest tilt of the camera below or above the horizon
constexpr double kLowest = 0.1, kHighest = 3;  // camera [m]
constexpr double kStraightDeg = 2;             // roll of a camera that is meant to be straight
constexpr double kLeastShare = 0.3;            // share of local models that show the floor
constexpr double kLeastNarrow = 0.75;          // share of those that show about the same floor
constexpr int kLeastModels = 10;
constexpr double kLeastDistance = 2;  // [m]
constexpr std::size_t kSeeds = 500;   // planes that are tried as the floor

struct Plane {
  int model;
  Eigen::Vector3d normal;
  double offset;
};

std::vector<Plane> planesBelow(const Map& map) {
  std::vector<Plane> planes;
  for (int i = 0; i < static_cast<int>(map.models.size()); ++i) {
    const std::shared_ptr<const View> view = map.view(i);
    for (const Segment& s : view->segments) {
      const double offset = s.offset();
      if (s.normal().y() > std::cos(kSteepest) && offset > kLowest && offset < kHighest)
        planes.push_back({i, s.normal(), offset});
    }
  }
  return planes;
}

/** One plane of each model at most: the most similar. Planes are in the order of their models. \param
 * tolerance factor on the deviations of one floor */
std::vector<Plane> similar(const std::vector<Plane>& planes, const Plane& floor, double tolerance = 1) {
  const auto difference = [&](const Plane& p) {
    return std::max(std::abs(p.offset - floor.offset) / kSameHeight,
                    p.normal.cross(floor.normal).norm() / std::sin(kSameAngle)) /
           tolerance;
  };
  std::vector<Plane> found;
  for (const Plane& p : planes) {
    if (!(difference(p) <= 1) || p.normal.dot(floor.normal) < 0) continue;
    if (found.empty() || found.back().model != p.model)
      found.push_back(p);
    else if (difference(p) < difference(found.back()))
      found.back() = p;
  }
  return found;
}

Plane meanOf(const std::vector<Plane>& planes) {
  Plane mean{-1, Eigen::Vector3d::Zero(), 0};
  for (const Plane& p : planes) mean.normal += p.normal, mean.offset += p.offset;
  mean.normal.normalize();
  mean.offset /= static_cast<double>(planes.size());
  return mean;
}

double heightStd(const std::vector<Plane>& planes, double mean) {
  double sum = 0;
  for (const Plane& p : planes) sum += (p.offset - mean) * (p.offset - mean);
  return std::sqrt(sum / static_cast<double>(planes.size()));
}

bool hasMoved(const Map& map) {
  std::map<int, Eigen::AlignedBox3d> ways;  // keyed by part
  for (const LocalModel& model : map.models)
    if (model.T_w_m) ways[model.part].extend(model.T_w_m->translation());
  return std::any_of(ways.begin(), ways.end(),
                     [](const auto& seen) { return seen.second.diagonal().norm() >= kLeastDistance; });
}

}  // namespace

std::string FoundMounting::toString() const {
  return fmt::format("{}, by the floor in {} of {} local models", facetloc::toString(mounting), models,
                     all_models);
}

CameraMounting SeenFloor::mounting() const {
  return {height, tilt_deg, std::abs(roll_deg) > kStraightDeg ? roll_deg : 0};
}

std::optional<SeenFloor> findFloor(const Map& map) {
  const std::vector<Plane> planes = planesBelow(map);
  if (planes.empty()) return {};
  std::vector<Plane> best;
  const std::size_t step = std::max<std::size_t>(1, planes.size() / kSeeds);
  for (std::size_t i = 0; i < planes.size(); i += step)
    if (std::vector<Plane> found = similar(planes, planes[i]); found.size() > best.size())
      best = std::move(found);
  best = similar(planes, meanOf(best));
  const int all = static_cast<int>(map.models.size()), n = static_cast<int>(best.size());
  if (n < kLeastModels || n < kLeastShare * all) return {};
  const Plane floor = meanOf(best);
  const Eigen::Vector3d& down = floor.normal;
  const double std = heightStd(best, floor.offset);
  const bool spreads =
      n < kLeastNarrow * static_cast<double>(similar(planes, floor, kWide).size()) || std > kMostHeightStd;
  return SeenFloor{
      floor.offset, std::asin(down.z()) / kDegree, std::atan2(down.x(), down.y()) / kDegree, std, n, all,
      !spreads};
}

std::optional<FoundMounting> findMounting(const Map& map) {
  const auto floor = findFloor(map);
  if (!floor || !floor->steady || !hasMoved(map)) return {};
  return FoundMounting{floor->mounting(), floor->views, floor->all_views};
}

}  // namespace facetloc
