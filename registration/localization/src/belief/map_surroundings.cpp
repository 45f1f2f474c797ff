// SPDX-License-Identifier: BSD-3-Clause
#include "belief/map_surroundings.h"

#include <cmath>

namespace facetloc::internal {

MapSurroundings::MapSurroundings(std::shared_ptr<const Map> map, const DepthComparison& comparison)
    : map_(std::move(map)), comparison_(comparison), near_(map_) {}

LocalMap MapSurroundings::around(const View& view, int part, const Eigen::Isometry3d& T_w_c, int n) const {
  constexpr int kCompared = 3;       // times as many models are compared as are wanted
  constexpr int kFewestPixels = 15;  // pixels of the coarse grid that a model must confirm: a twentieth
  struct Found {
    int model;
    std::shared_ptr<const View> view;
  };
  std::vector<Found> confirming, silent;  // nearest first
  for (const int i : near_.bySight(part, T_w_c, kTrackingReach, kCompared * n)) {
    const Eigen::Isometry3d T_m_c = map_->models[i].T_w_m->inverse() * T_w_c;
    Found found{i, map_->view(i)};
    const int pixels = comparison_.count(view.depth, found.view->depth, T_m_c, kCoarseColumns).agree;
    (pixels >= kFewestPixels ? confirming : silent).push_back(std::move(found));
  }
  LocalMap out;
  const auto add = [&](const std::vector<Found>& models, bool with_picture) {
    for (const Found& found : models) {
      if (static_cast<int>(out.views.size()) >= n) return;
      out.add(found.model, found.view, *map_->models[found.model].T_w_m);
      if (!with_picture && !found.view->depth.empty()) out.pictures.pop_back();
    }
  };
  add(confirming, true);
  add(silent, false);
  return out;
}

std::optional<FloorPlane> MapSurroundings::floorNear(int part, const Eigen::Isometry3d& T_w_c, int n,
                                                     const Eigen::Matrix3d& covariance) const {
  constexpr int kAsked = 3;  // times as many models are asked as are wanted
  constexpr double kStep = 0.1,
                   kSlope = 0.05;  // tolerance of one floor [m], and its growth with the distance
  if (!map_->camera.mounting || near_.empty()) return {};
  const std::vector<int> near = near_.byPlace(part, T_w_c.translation(), kAsked * n);
  const Eigen::Isometry3d T_c_b = map_->camera.mounting->T_b_c().inverse();
  const Eigen::Vector3d here = (T_w_c * T_c_b).translation();
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const int i : near) up += map_->models[i].T_w_m->linear() * T_c_b.linear().col(2);
  up.normalize();
  std::vector<Eigen::Isometry3d> poses;  // on the floor that the robot stands on, nearest first
  for (const int i : near) {
    const Eigen::Isometry3d& T_w_m = *map_->models[i].T_w_m;
    const Eigen::Vector3d away = (T_w_m * T_c_b).translation() - here;
    if (std::abs(up.dot(away)) > kStep + kSlope * away.norm()) continue;
    if (static_cast<int>(poses.size()) < n) poses.push_back(T_w_m);
  }
  if (poses.empty()) return {};
  return floorUnder(poses, *map_->camera.mounting, covariance, T_w_c.translation());
}

}  // namespace facetloc::internal
