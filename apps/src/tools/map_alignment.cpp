// SPDX-License-Identifier: BSD-3-Clause
#include "tools/map_alignment.h"

#include "base/progress.h"
#include "base/text.h"

#include <facetloc/io/error.h>
#include <facetloc/io/text.h>

#include <algorithm>

namespace facetloc {
namespace {

constexpr std::size_t kMostViews = 30;  // of a map that are looked for in another one, spread over it

bool hasPoses(const Map& map) {
  return std::any_of(map.models.begin(), map.models.end(),
                     [](const LocalModel& m) { return m.T_w_m.has_value(); });
}

/** Some views of a map, as images of a session. */
CameraTrajectory someViews(const Map& map) {
  std::vector<const LocalModel*> posed;
  for (const LocalModel& model : map.models)
    if (model.T_w_m) posed.push_back(&model);
  const auto camera = std::make_shared<const Camera>(map.camera);
  CameraTrajectory some;
  const std::size_t n = std::min(kMostViews, posed.size());
  for (std::size_t i = 0; i < n; ++i) {
    const LocalModel& model = *posed[i * posed.size() / n];
    const auto view = std::make_shared<View>(model.view);
    if (!view->camera) view->camera = camera;
    some.images.push_back({model.stamp, *model.T_w_m, static_cast<int>(i)});
    some.keyframes.push_back({i, view, {*model.T_w_m, Matrix6d::Zero()}, 0});
  }
  return some;
}

std::string inWords(const Eigen::Isometry3d& T) {
  return text::decimals(T.translation().norm(), 2) + " m and " +
         text::decimals(rotationAngle(T.linear()) / kDegree, 1) + " deg";
}

}  // namespace

void alignMaps(std::vector<Map>& maps, const std::vector<std::string>& paths, int threads,
               const Console& console) {
  for (std::size_t i = 1; i < maps.size(); ++i) {
    if (!hasPoses(maps[i])) continue;
    const CameraTrajectory views = someViews(maps[i]);
    std::string tried;
    bool placed = false, asked = false;
    for (std::size_t k = 0; k < i && !placed; ++k) {
      if (!hasPoses(maps[k])) continue;
      asked = true;
      const GlobalLocalization localization(borrowed(maps[k]));
      Progress progress(console, views.keyframes.size());
      const SessionPlace place = placeRigidly(localization, views, MapBuilderParams(), MapSessionParams(),
                                              threads, [&] { progress.step(); });
      tried += "; in " + paths[k] + ", " + place.inWords();
      placed = place.found();
      if (!placed) continue;
      const Eigen::Isometry3d T_new_old = *place.T_w_k.front() * views.keyframes.front().T_w_c.T.inverse();
      const bool stays = isNear(T_new_old, Eigen::Isometry3d::Identity(), 1e-9, 1e-6);
      console.out << paths[i] << " is found in " << paths[k] << " (" << place.inWords() << ") and "
                  << (stays ? "stays where it is" : "moves by " + inWords(T_new_old)) << "\n";
      for (LocalModel& model : maps[i].models)
        if (model.T_w_m && !stays) model.T_w_m = T_new_old * *model.T_w_m;
    }
    if (asked && !placed)
      throw IoError(paths[i], "is not found in the maps before it" + tried +
                                  "; --same-coordinates merges maps that share a world frame as they are");
  }
}

}  // namespace facetloc
