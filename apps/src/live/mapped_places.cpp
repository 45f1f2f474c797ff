// SPDX-License-Identifier: BSD-3-Clause
#include "live/mapped_places.h"

#include <algorithm>
#include <map>
#include <queue>

namespace facetloc {
namespace {

constexpr double kNearDistance = 0.35, kNearRotationDeg = 10;  // of a place that is there already [m]
constexpr double kOwnRotation = 0.2 * kDegree, kOwnTranslation = 0.01;  // of an image beside its keyframe [m]

Eigen::Isometry3d poseOf(const MappedPlace& place, const TrajectoryEstimation& trajectory) {
  return trajectory.pose(place.keyframe).T * place.T_k_m;
}

/** The motions of a trajectory, to go from one keyframe to another by as few of them as possible. */
class Motions {
public:
  explicit Motions(const CameraTrajectory& trajectory)
      : trajectory_(trajectory), of_(trajectory.keyframes.size()) {
    for (std::size_t i = 0; i < trajectory.motions.size(); ++i) {
      const KeyframeMotion& m = trajectory.motions[i];
      of_[static_cast<std::size_t>(m.from)].push_back(i);
      of_[static_cast<std::size_t>(m.to)].push_back(i);
    }
  }

  /** T_a_b with what its motions know of it; nothing if none lead there. */
  std::optional<PoseWithCovariance> between(int a, int b) const {
    std::map<int, PoseWithCovariance> reached = {{a, {}}};
    std::queue<int> open;
    open.push(a);
    while (!open.empty() && !reached.count(b)) {
      const int here = open.front();
      open.pop();
      for (const std::size_t i : of_[static_cast<std::size_t>(here)]) {
        const KeyframeMotion& m = trajectory_.motions[i];
        const bool forward = m.from == here;
        const int there = forward ? m.to : m.from;
        if (reached.count(there)) continue;
        reached[there] = reached[here] * (forward ? m.T_from_to : inverse(m.T_from_to));
        open.push(there);
      }
    }
    const auto found = reached.find(b);
    if (found == reached.end()) return {};
    return found->second;
  }

private:
  const CameraTrajectory& trajectory_;
  std::vector<std::vector<std::size_t>> of_;
};

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

  const Motions motions(trajectory);
  Vector6d own;
  own << Eigen::Vector3d::Constant(kOwnRotation), Eigen::Vector3d::Constant(kOwnTranslation);
  std::vector<Link> links;
  for (const auto& [from, to] : pairs) {
    const MappedPlace &a = places_[from], &b = places_[to];
    const auto way = motions.between(a.keyframe, b.keyframe);
    if (!way) continue;
    const Eigen::Isometry3d T_a_b =
        trajectory.keyframes[a.keyframe].T_w_c.T.inverse() * trajectory.keyframes[b.keyframe].T_w_c.T;
    const Eigen::Isometry3d T_from_k = a.T_k_m.inverse();
    PoseWithCovariance T = T_from_k * *way * PoseWithCovariance{b.T_k_m, own.cwiseAbs2().asDiagonal()};
    T.T = T_from_k * T_a_b * b.T_k_m;
    links.push_back({from, to, T});
  }
  return links;
}

}  // namespace facetloc
