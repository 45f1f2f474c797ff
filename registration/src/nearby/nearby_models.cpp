// SPDX-License-Identifier: BSD-3-Clause
#include "nearby/nearby_models.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace facetloc::internal {
namespace {

std::vector<int> nearest(std::vector<std::pair<double, int>>& near, int n) {
  const auto count = std::min<std::ptrdiff_t>(n, static_cast<std::ptrdiff_t>(near.size()));
  std::partial_sort(near.begin(), near.begin() + count, near.end());
  std::vector<int> models;
  for (std::ptrdiff_t i = 0; i < count; ++i) models.push_back(near[static_cast<std::size_t>(i)].second);
  return models;
}

}  // namespace

NearbyModels::NearbyModels(std::shared_ptr<const Map> map, bool with_picture) : map_(std::move(map)) {
  for (std::size_t i = 0; i < map_->models.size(); ++i) {
    const LocalModel& m = map_->models[i];
    if (m.T_w_m && (m.hasPicture() || !with_picture))
      places_.push_back({m.part, m.T_w_m->translation(), static_cast<int>(i)});
  }
  std::stable_sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) {
    return a.part != b.part ? a.part < b.part : a.t.x() < b.t.x();
  });
}

NearbyModels NearbyModels::without(const std::function<bool(int)>& absent) const {
  NearbyModels rest = *this;
  const auto isAbsent = [&](const Place& place) { return absent(place.model); };
  rest.places_.erase(std::remove_if(rest.places_.begin(), rest.places_.end(), isAbsent), rest.places_.end());
  return rest;
}

// Places less than a distance from another of their part, if any is: by a window in x.
template <class Visitor>
void NearbyModels::forEachWithin(int part, const Eigen::Vector3d& place, double distance,
                                 const Visitor& visit) const {
  auto p = std::lower_bound(
      places_.begin(), places_.end(), place.x() - distance,
      [part](const Place& a, double x) { return a.part != part ? a.part < part : a.t.x() < x; });
  for (; p != places_.end() && p->part == part && p->t.x() <= place.x() + distance; ++p) {
    const double squared = (p->t - place).squaredNorm();
    if (squared < distance * distance) visit(p->model, squared);
  }
}

std::vector<int> NearbyModels::bySight(int part, const Eigen::Isometry3d& T_w_c, const ViewReach& reach,
                                       int n) const {
  std::vector<std::pair<double, int>> near;
  forEachWithin(part, T_w_c.translation(), reach.distance, [&](int model, double) {
    const double distance = viewDistance(*map_->models[static_cast<std::size_t>(model)].T_w_m, T_w_c, reach);
    if (std::isfinite(distance)) near.emplace_back(distance, model);
  });
  return nearest(near, n);
}

std::vector<int> NearbyModels::byPlace(int part, const Eigen::Vector3d& place, int n) const {
  constexpr double kFirst = 2, kFarthest = 1e7;  // [m]
  std::vector<std::pair<double, int>> near;
  const auto wanted = static_cast<std::size_t>(std::max(n, 0));
  for (double distance = kFirst; near.size() < wanted && distance < kFarthest; distance *= 2) {
    near.clear();
    forEachWithin(part, place, distance,
                  [&](int model, double squared) { near.emplace_back(squared, model); });
  }
  return nearest(near, n);
}

}  // namespace facetloc::internal
