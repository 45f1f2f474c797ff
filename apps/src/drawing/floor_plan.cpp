// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/floor_plan.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <cmath>

namespace facetloc {

Eigen::AlignedBox2d FloorPlan::extent() const {
  Eigen::AlignedBox2d extent;
  for (const PlanLine& wall : walls) extent.extend(wall.from), extent.extend(wall.to);
  for (const Eigen::Isometry3d& T : models) extent.extend(view.point(T.translation()));
  return extent;
}

FloorPlan floorPlan(const Map& map, int part) {
  FloorPlan plan{PlanView(upInPart(map, part)), {}, {}, {}};
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const LocalModel& model = map.models[i];
    if (!model.T_w_m || model.part != part) continue;
    plan.models.push_back(*model.T_w_m);
    for (const Segment& segment : map.view(static_cast<int>(i))->segments)
      if (const auto line = plan.view.line(segment, *model.T_w_m)) plan.walls.push_back(*line);
  }
  for (const Link& link : map.links) {
    const auto &from = map.models[link.from].T_w_m, &to = map.models[link.to].T_w_m;
    if (from && to && map.models[link.from].part == part)
      plan.links.push_back({from->translation(), to->translation()});
  }
  return plan;
}

FloorPlan floorPlan(const Map& map, const std::filesystem::path& picture) {
  if (std::none_of(map.models.begin(), map.models.end(),
                   [](const LocalModel& m) { return m.T_w_m.has_value(); }))
    throw IoError(picture.string(), "cannot be drawn: no local model of the map has a pose");
  return floorPlan(map, mainPart(map));
}

void extend(Eigen::AlignedBox2d& extent, const PlanView& view, const std::vector<DrawnRun>& runs,
            const std::vector<DrawnMarks>& marks) {
  const auto add = [&](const std::vector<Eigen::Isometry3d>& poses) {
    for (const Eigen::Isometry3d& T : poses) extent.extend(view.point(T.translation()));
  };
  for (const DrawnRun& run : runs) add(run.T_w_c);
  for (const DrawnMarks& mark : marks) add(mark.T_w_c);
}

double roundLength(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= length) return factor * power;
  return power;
}

double pixelsPerMetreFor(const Eigen::AlignedBox2d& extent, double width, double height) {
  constexpr double kMost = 250;
  const Eigen::Vector2d size = extent.sizes().cwiseMax(kLeastExtent);
  return std::min({width / size.x(), height / size.y(), kMost});
}

}  // namespace facetloc
