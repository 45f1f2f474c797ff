// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/mounting_check.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace facetloc::internal {
namespace {

constexpr double kSameAngle = 6.5 * kDegree,
                 kSameHeight = 0.08;  // tolerances of a robot on an uneven floor [m]
constexpr double kLevel =
    15 * kDegree;  // up to this angle, a plane would be level or upright if the camera stood otherwise
constexpr double kOtherWay = 30 * kDegree;  // between walls that together tell the vertical
constexpr double kLeastSupport = 300;       // least support of a wall [px]

/** Evidence of the planes of a view about a mounting. */
enum class MountingSight { shows, open, contradicts };

Eigen::Vector3d downIn(const CameraMounting& mounting) {
  return -(mounting.T_b_c().linear().transpose() * Eigen::Vector3d::UnitZ());
}

// Within the tolerance of a robot on its floor; a camera in the hand is hardly ever held so exactly.
bool agreesWithGravity(const Gravity& gravity, const CameraMounting& mounting) {
  constexpr double kGate = 3, kOfRobot = 1.5 * kDegree;  // standard deviations; of a robot that leans
  const double angle = std::acos(std::clamp(downIn(mounting).dot(gravity.down), -1.0, 1.0));
  return angle < std::min(kSameAngle, kGate * std::hypot(gravity.std, kOfRobot));
}

MountingSight sightOf(const View& view, const CameraMounting& mounting) {
  const Eigen::Vector3d down = downIn(mounting);
  std::vector<Eigen::Vector3d> walls;
  bool shows_level = false;  // something above the floor
  for (const Segment& s : view.segments) {
    const double to_down = std::acos(std::clamp(s.normal().dot(down), -1.0, 1.0));
    if (to_down < kLevel) {
      const double above_floor = mounting.height - s.offset();
      if (to_down > kSameAngle || above_floor < -kSameHeight) return MountingSight::contradicts;
      if (above_floor < kSameHeight) return MountingSight::shows;
      shows_level = true;
    }
    const double from_upright = std::abs(to_down - 90 * kDegree);
    if (s.num_points < kLeastSupport || from_upright > kLevel) continue;
    if (from_upright > kSameAngle) return MountingSight::contradicts;
    walls.push_back(s.normal());
  }
  const auto isOfTwo = [&](const Eigen::Vector3d& a) {
    return std::any_of(walls.begin(), walls.end(),
                       [&](const Eigen::Vector3d& b) { return a.cross(b).norm() > std::sin(kOtherWay); });
  };
  const bool shows = shows_level || std::any_of(walls.begin(), walls.end(), isOfTwo);
  return shows ? MountingSight::shows : MountingSight::open;
}

}  // namespace

bool showsMounting(const View& view, const CameraMounting& mounting) {
  const MountingSight sight = sightOf(view, mounting);
  if (!view.gravity || !view.gravity->valid()) return sight == MountingSight::shows;
  return sight != MountingSight::contradicts && agreesWithGravity(*view.gravity, mounting);
}

CameraDifference differenceFrom(const Camera& of_map, const View& view) {
  static const Camera unknown;
  CameraDifference difference = differenceOf(view.camera ? *view.camera : unknown, of_map, view.noise());
  if (difference.mounting == CameraDifference::Mounting::unknown && showsMounting(view, *of_map.mounting))
    difference.mounting = CameraDifference::Mounting::same;
  return difference;
}

}  // namespace facetloc::internal
