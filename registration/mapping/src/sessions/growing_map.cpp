// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/mapped_places.h"

#include <facetloc/mapping/growing_map.h>

#include <algorithm>
#include <limits>

namespace facetloc {

using namespace internal;

namespace {

TrajectoryEstimation endless(const MappingParams& params) {
  TrajectoryEstimation trajectory(params);
  trajectory.setEndless(true);
  return trajectory;
}

}  // namespace

struct GrowingMap::Impl {
  TrajectoryEstimation trajectory;
  MappedPlaces places;
  int main_part = 0, compared = 0, loops = 0;
};

GrowingMap::GrowingMap(const MappingParams& trajectory, const MapBuilderParams& places)
    : GrowingMap(std::make_unique<Impl>(Impl{endless(trajectory), MappedPlaces(places)})) {}
GrowingMap::GrowingMap(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GrowingMap::GrowingMap(GrowingMap&&) noexcept = default;
GrowingMap& GrowingMap::operator=(GrowingMap&&) noexcept = default;
GrowingMap::~GrowingMap() = default;

bool GrowingMap::add(const View& view, const std::string& name, double stamp,
                     const std::optional<Eigen::Isometry3d>& motion) {
  impl_->trajectory.add(view, stamp, motion);
  return impl_->places.visit(impl_->trajectory, view, name, stamp);
}

void GrowingMap::interrupt() { impl_->trajectory.interrupt(); }

std::optional<PoseWithCovariance> GrowingMap::latest() const {
  const TrajectoryEstimation& trajectory = impl_->trajectory;
  if (keyframes() == 0 || trajectory.part(trajectory.latestKeyframe()) != impl_->main_part) return {};
  return trajectory.latest();
}

int GrowingMap::size() const { return static_cast<int>(impl_->places.places().size()); }
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
  return impl_->places.poses(impl_->trajectory, impl_->main_part);
}

std::vector<Link> GrowingMap::links() const { return impl_->places.links(impl_->trajectory.trajectory()); }

std::shared_ptr<const Map> GrowingMap::map(const Camera& camera) const {
  auto map = std::make_shared<Map>();
  map->camera = camera;
  map->links = links();
  const auto T_w_m = poses();
  for (std::size_t i = 0; i < T_w_m.size(); ++i) {
    const MappedPlace& place = impl_->places.places()[i];
    map->models.emplace_back(place.name, place.stamp, T_w_m[i]);
    map->models.back().setView(place.view);
  }
  return map;
}

}  // namespace facetloc
