// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/map_surroundings.h>

#include <algorithm>
#include <cmath>

namespace facetloc {

MapSurroundings::MapSurroundings(std::shared_ptr<const Map> map, const DepthComparison& comparison)
    : map_(std::move(map)),
      comparison_(comparison),
      any_pose_(std::any_of(map_->models.begin(), map_->models.end(),
                            [](const LocalModel& m) { return m.T_w_m.has_value(); })) {}

Surroundings MapSurroundings::around(const View& view, const Eigen::Isometry3d& T_w_c, int n) const {
  constexpr int kCompared = 3;       // times as many models are compared as are wanted
  constexpr int kFewestPixels = 15;  // of the coarse grid, that a model must confirm: a twentieth
  std::vector<std::pair<double, int>> near;
  for (std::size_t i = 0; i < map_->models.size(); ++i) {
    const LocalModel& m = map_->models[i];
    if (!m.T_w_m) continue;
    const double distance = viewDistance(*m.T_w_m, T_w_c);
    if (std::isfinite(distance)) near.emplace_back(distance, static_cast<int>(i));
  }
  std::sort(near.begin(), near.end());
  if (static_cast<int>(near.size()) > kCompared * n) near.resize(kCompared * n);

  std::vector<int> confirming, silent;  // models, nearest first
  for (const auto& [distance, i] : near) {
    const LocalModel& m = map_->models[i];
    const Eigen::Isometry3d T_m_c = m.T_w_m->inverse() * T_w_c;
    const int pixels = comparison_.compare(view.depth, m.view.depth, T_m_c, kCoarseColumns).agree;
    (pixels >= kFewestPixels ? confirming : silent).push_back(i);
  }
  const std::size_t with_picture = confirming.size();
  confirming.insert(confirming.end(), silent.begin(), silent.end());
  Surroundings out;
  for (std::size_t k = 0; k < confirming.size() && static_cast<int>(k) < n; ++k) {
    const LocalModel& m = map_->models[confirming[k]];
    out.add(confirming[k], m.view, *m.T_w_m);
    if (k >= with_picture && !m.view.depth.empty()) out.pictures.pop_back();
  }
  return out;
}

std::optional<FloorPlane> MapSurroundings::floorNear(const Eigen::Vector3d& place, int n) const {
  if (!map_->mounting || !any_pose_) return {};
  std::vector<Eigen::Isometry3d> poses;
  for (const LocalModel& m : map_->models)
    if (m.T_w_m) poses.push_back(*m.T_w_m);
  const auto nearer = [&](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    return (a.translation() - place).squaredNorm() < (b.translation() - place).squaredNorm();
  };
  const auto count = std::min<std::ptrdiff_t>(n, static_cast<std::ptrdiff_t>(poses.size()));
  std::partial_sort(poses.begin(), poses.begin() + count, poses.end(), nearer);
  poses.resize(static_cast<std::size_t>(count));
  return floorUnder(poses, *map_->mounting);
}

}  // namespace facetloc
