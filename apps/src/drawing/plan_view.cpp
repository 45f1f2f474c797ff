// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/plan_view.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace facetloc {
namespace {

constexpr double kWorldTilt = 20 * kDegree;  // a world whose z axis is nearer to the vertical has z up
constexpr double kLean = 15 * kDegree;       // largest lean of an upright segment

struct WeightedNormal {
  Eigen::Vector3d normal;
  double area;  // [m^2]
};

/** The direction near a guess that most area is at right angles to. */
Eigen::Vector3d levelNormal(const std::vector<WeightedNormal>& normals, Eigen::Vector3d up) {
  for (const double reach : {30.0, 15.0, 5.0, 5.0}) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const WeightedNormal& n : normals) {
      const double cosine = n.normal.dot(up);
      if (std::abs(cosine) > std::cos(reach * kDegree)) sum += n.area * (cosine > 0 ? n.normal : -n.normal);
    }
    if (sum.norm() > 0) up = sum.normalized();
  }
  return up;
}

std::vector<WeightedNormal> normalsOf(const View& view, const Eigen::Matrix3d& R) {
  std::vector<WeightedNormal> normals;
  for (const Segment& s : view.segments) normals.push_back({R * s.normal(), s.area()});
  return normals;
}

Eigen::Vector3d guessInView(const std::optional<CameraMounting>& mounting) {
  return mounting ? Eigen::Vector3d(mounting->T_b_c().linear().row(2).transpose())
                  : Eigen::Vector3d(0, -1, 0);
}

}  // namespace

std::vector<Eigen::Isometry3d> posesOf(const Trajectory& trajectory) {
  std::vector<Eigen::Isometry3d> poses;
  for (const StampedPose& pose : trajectory.poses()) poses.push_back(pose.T_w_c);
  return poses;
}

std::vector<Eigen::Vector3d> cornersOf(const Segment& segment, const Eigen::Isometry3d& T) {
  std::vector<Eigen::Vector3d> corners;
  for (const Eigen::Vector2f& v : segment.hull)
    corners.push_back(T * (segment.t + segment.R.leftCols<2>() * v.cast<double>()));
  return corners;
}

Eigen::Vector3d upInView(const View& view, const std::optional<CameraMounting>& mounting) {
  const Eigen::Vector3d guess = guessInView(mounting);
  return mounting ? guess : levelNormal(normalsOf(view, Eigen::Matrix3d::Identity()), guess);
}

Eigen::Vector3d upInPart(const Map& map, int part) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<WeightedNormal> normals;
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const auto& T_w_m = map.models[i].T_w_m;
    if (!T_w_m || map.models[i].part != part) continue;
    sum += T_w_m->linear() * guessInView(map.camera.mounting);
    const auto more = normalsOf(*map.view(static_cast<int>(i)), T_w_m->linear());
    normals.insert(normals.end(), more.begin(), more.end());
  }
  const Eigen::Vector3d up = levelNormal(normals, sum.normalized());
  return up.z() > std::cos(kWorldTilt) ? Eigen::Vector3d::UnitZ() : up;
}

PlanView::PlanView(const Eigen::Vector3d& up) : up_(up) {
  axes_ = rotationBetween(up, Eigen::Vector3d::UnitZ()).topRows<2>();
}

std::optional<PlanLine> PlanView::line(const Segment& segment, const Eigen::Isometry3d& T_w_m) const {
  const Eigen::Matrix3d R = T_w_m.linear() * segment.R;
  if (segment.hull.size == 0 || std::abs(R.col(2).dot(up_)) > std::sin(kLean)) return {};
  const Eigen::Vector3d along = up_.cross(R.col(2)).normalized();
  double first = std::numeric_limits<double>::max(), last = -first, lowest = first, highest = -first;
  for (const Eigen::Vector2f& vertex : segment.hull) {
    const Eigen::Vector3d p = R.leftCols<2>() * vertex.cast<double>();
    first = std::min(first, along.dot(p)), last = std::max(last, along.dot(p));
    lowest = std::min(lowest, up_.dot(p)), highest = std::max(highest, up_.dot(p));
  }
  const Eigen::Vector3d centre = T_w_m * segment.t;
  return PlanLine{point(centre + first * along), point(centre + last * along), highest - lowest};
}

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

double roundLength(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= length) return factor * power;
  return power;
}

}  // namespace facetloc
