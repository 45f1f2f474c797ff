// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/mapped_places.h"

#include "trajectory/trajectory_links.h"

#include <algorithm>
#include <map>

namespace facetloc::internal {
namespace {

constexpr double kNearDistance = 0.35, kNearRotationDeg = 10;  // radius of an existing place [m, deg]

Eigen::Isometry3d poseOf(const MappedPlace& place, const TrajectoryEstimation& trajectory) {
  return trajectory.pose(place.keyframe).T * place.T_k_m;
}

}  // namespace

std::optional<int> MappedPlaces::near(const TrajectoryEstimation& trajectory, int part,
                                      const Eigen::Isometry3d& T_w_c) const {
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (trajectory.part(places_[i].keyframe) == part &&
        isNear(poseOf(places_[i], trajectory), T_w_c, kNearDistance, kNearRotationDeg))
      return static_cast<int>(i);
  return {};
}

bool MappedPlaces::visit(const TrajectoryEstimation& trajectory, const View& view, const std::string& name,
                         double stamp) {
  const int keyframe = trajectory.latestKeyframe(), part = trajectory.part(keyframe);
  const Eigen::Isometry3d T_w_c = trajectory.latest().T;
  const bool goes_on = latest_ && trajectory.part(places_[*latest_].keyframe) == part;
  if (view.segments.empty() || (goes_on && isNear(poseOf(places_[*latest_], trajectory), T_w_c,
                                                  params_.distance, params_.rotation_deg)))
    return false;
  std::optional<int> here = near(trajectory, part, T_w_c);
  const bool is_new = !here;
  if (is_new) {
    here = static_cast<int>(places_.size());
    auto planes = std::make_shared<View>();
    planes->intrinsics = view.intrinsics;
    planes->segments = view.segments;
    places_.push_back(
        {name, stamp, keyframe, trajectory.pose(keyframe).T.inverse() * T_w_c, std::move(planes)});
  }
  if (goes_on && *here != *latest_) next_.insert(std::minmax(*here, *latest_));
  latest_ = here;
  return is_new;
}

std::vector<std::optional<Eigen::Isometry3d>> MappedPlaces::poses(const TrajectoryEstimation& trajectory,
                                                                  int part) const {
  std::vector<std::optional<Eigen::Isometry3d>> T_w_m(places_.size());
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (trajectory.part(places_[i].keyframe) == part) T_w_m[i] = poseOf(places_[i], trajectory);
  return T_w_m;
}

std::vector<Link> MappedPlaces::links(const CameraTrajectory& trajectory) const {
  std::set<std::pair<int, int>> pairs = next_;
  std::map<int, int> place_of;  // a keyframe
  for (std::size_t i = 0; i < places_.size(); ++i) place_of.emplace(places_[i].keyframe, i);
  for (const KeyframeMotion& m : trajectory.motions) {
    if (m.source != KeyframeMotion::Source::loop) continue;
    const auto a = place_of.find(m.from), b = place_of.find(m.to);
    if (a != place_of.end() && b != place_of.end()) pairs.insert(std::minmax(a->second, b->second));
  }

  std::vector<PlaceOnTrajectory> places;
  for (const MappedPlace& place : places_) places.push_back({place.keyframe, place.T_k_m});
  return linksBetween(trajectory, places, pairs);
}

}  // namespace facetloc::internal
