// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/trajectory_graph.h"

#include <facetloc/mapping/growing_map.h>

#include <algorithm>
#include <limits>
#include <map>

namespace facetloc {

using namespace internal;

namespace {

constexpr double kNearDistance = 0.35, kNearRotationDeg = 10;  // radius of an existing place [m, deg]

/** An image that is a local model, as known to the keyframe that it is attached to. */
struct MappedPlace : PlaceOnTrajectory {
  std::string name;
  double stamp = 0;                  // [s]
  std::shared_ptr<const View> view;  // without its depth picture
};

/** The images that are local models: by the rule of MapBuilder, but where there is one already, no other. */
struct Places {
  MapBuilderParams params;
  std::vector<MappedPlace> all{};
  std::set<std::pair<int, int>> next{};  // numbers of places, the lower one first
  std::optional<int> latest{};
};

}  // namespace

struct GrowingMap::Impl {
  int part(const MappedPlace& place) const { return trajectory.part(place.keyframe); }
  Eigen::Isometry3d pose(const MappedPlace& place) const {
    return trajectory.pose(place.keyframe).T * place.T_k_c;
  }
  std::optional<int> placeNear(int part, const Eigen::Isometry3d& T_w_c) const;
  bool visit(const View& view, const std::string& name, double stamp);

  TrajectoryEstimation trajectory;
  Places places;
  int main_part = 0, compared = 0, loops = 0;
};

std::optional<int> GrowingMap::Impl::placeNear(int of_part, const Eigen::Isometry3d& T_w_c) const {
  for (std::size_t i = 0; i < places.all.size(); ++i)
    if (part(places.all[i]) == of_part && isNear(pose(places.all[i]), T_w_c, kNearDistance, kNearRotationDeg))
      return static_cast<int>(i);
  return {};
}

/** Returns true if the latest image of the trajectory has become a local model. */
bool GrowingMap::Impl::visit(const View& view, const std::string& name, double stamp) {
  const int keyframe = trajectory.latestKeyframe(), now = trajectory.part(keyframe);
  const Eigen::Isometry3d T_w_c = trajectory.latest().T;
  std::optional<int>& latest = places.latest;
  const bool goes_on = latest && part(places.all[*latest]) == now;
  if (view.segments.empty() || (goes_on && isNear(pose(places.all[*latest]), T_w_c, places.params.distance,
                                                  places.params.rotation_deg)))
    return false;
  std::optional<int> here = placeNear(now, T_w_c);
  const bool is_new = !here;
  if (is_new) {
    here = static_cast<int>(places.all.size());
    auto planes = std::make_shared<View>();
    planes->intrinsics = view.intrinsics;
    planes->segments = view.segments;
    places.all.push_back(
        {{keyframe, trajectory.pose(keyframe).T.inverse() * T_w_c}, name, stamp, std::move(planes)});
  }
  if (goes_on && *here != *latest) places.next.insert(std::minmax(*here, *latest));
  latest = here;
  return is_new;
}

GrowingMap::GrowingMap(const MappingParams& trajectory, const MapBuilderParams& places)
    : GrowingMap(std::make_unique<Impl>(Impl{TrajectoryEstimation(trajectory), {places}})) {
  impl_->trajectory.setEndless(true);
}
GrowingMap::GrowingMap(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GrowingMap::GrowingMap(GrowingMap&&) noexcept = default;
GrowingMap& GrowingMap::operator=(GrowingMap&&) noexcept = default;
GrowingMap::~GrowingMap() = default;

bool GrowingMap::add(const View& view, const std::string& name, double stamp,
                     const std::optional<Eigen::Isometry3d>& motion) {
  impl_->trajectory.add(view, stamp, motion);
  return impl_->visit(view, name, stamp);
}

void GrowingMap::interrupt() { impl_->trajectory.interrupt(); }

std::optional<PoseWithCovariance> GrowingMap::latest() const {
  const TrajectoryEstimation& trajectory = impl_->trajectory;
  if (keyframes() == 0 || trajectory.part(trajectory.latestKeyframe()) != impl_->main_part) return {};
  return trajectory.latest();
}

int GrowingMap::size() const { return static_cast<int>(impl_->places.all.size()); }
int GrowingMap::keyframes() const { return impl_->trajectory.keyframes(); }
int GrowingMap::loops() const { return impl_->loops; }

std::vector<Eigen::Vector3d> GrowingMap::trajectory() const {
  std::vector<Eigen::Vector3d> trajectory;
  for (int k = 0; k < keyframes(); ++k)
    if (impl_->trajectory.part(k) == impl_->main_part)
      trajectory.emplace_back(impl_->trajectory.pose(k).T.translation());
  return trajectory;
}

bool GrowingMap::canBeImproved() const { return impl_->compared < keyframes(); }

void GrowingMap::improve(const std::function<void(double)>& progress) {
  Impl& m = *impl_;
  m.trajectory.improve(progress, m.compared);
  m.compared = keyframes();
  const CameraTrajectory improved = m.trajectory.trajectory();
  const std::vector<int> parts = improved.parts();
  m.main_part = parts.empty() ? 0 : parts.front();
  m.loops = improved.loops();
}

GrowingMap GrowingMap::clone() const {
  const Impl& m = *impl_;
  return GrowingMap(
      std::make_unique<Impl>(Impl{m.trajectory.clone(), m.places, m.main_part, m.compared, m.loops}));
}

double GrowingMap::adopt(const GrowingMap& improved) {
  Impl& m = *impl_;
  const Impl& other = *improved.impl_;
  double moved = m.main_part == other.main_part ? 0 : std::numeric_limits<double>::infinity();
  for (int k = 0; k < improved.keyframes(); ++k)
    moved = std::max(
        moved, (other.trajectory.pose(k).T.translation() - m.trajectory.pose(k).T.translation()).norm());
  m.trajectory.adopt(other.trajectory);
  m.main_part = other.main_part, m.compared = other.compared, m.loops = other.loops;
  return moved;
}

std::vector<std::optional<Eigen::Isometry3d>> GrowingMap::poses() const {
  std::vector<std::optional<Eigen::Isometry3d>> T_w_m;
  for (const MappedPlace& place : impl_->places.all)
    T_w_m.push_back(impl_->part(place) == impl_->main_part ? std::optional(impl_->pose(place))
                                                           : std::nullopt);
  return T_w_m;
}

std::vector<Link> GrowingMap::links() const {
  const Impl& m = *impl_;
  const CameraTrajectory trajectory = m.trajectory.trajectory();
  std::set<std::pair<int, int>> pairs = m.places.next;
  std::map<int, int> place_of;  // a keyframe
  for (int i = 0; i < size(); ++i) place_of.emplace(m.places.all[i].keyframe, i);
  for (const KeyframeMotion& motion : trajectory.motions) {
    if (motion.source != KeyframeMotion::Source::loop) continue;
    const auto a = place_of.find(motion.from), b = place_of.find(motion.to);
    if (a != place_of.end() && b != place_of.end()) pairs.insert(std::minmax(a->second, b->second));
  }
  return linksBetween(trajectory, {m.places.all.begin(), m.places.all.end()}, pairs);
}

std::shared_ptr<const Map> GrowingMap::map(const Camera& camera) const {
  auto map = std::make_shared<Map>();
  map->camera = camera;
  map->links = links();
  const auto T_w_m = poses();
  for (std::size_t i = 0; i < T_w_m.size(); ++i) {
    const MappedPlace& place = impl_->places.all[i];
    map->models.emplace_back(place.name, place.stamp, T_w_m[i]);
    map->models.back().setView(place.view);
  }
  return map;
}

}  // namespace facetloc
