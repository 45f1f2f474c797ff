// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/session_place.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/map_parts.h>
#include <facetloc/mapping/map_session.h>

#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <stdexcept>

namespace facetloc {

using namespace internal;

namespace {

constexpr std::size_t kMostViews = 30;  // views of a map that are localized in another one, spread over it

bool hasPoses(const Map& map) {
  return std::any_of(map.models.begin(), map.models.end(),
                     [](const LocalModel& m) { return m.T_w_m.has_value(); });
}

/** Some views of a map, as images of a session. */
CameraTrajectory someViews(const Map& map) {
  std::vector<int> posed;
  for (std::size_t i = 0; i < map.models.size(); ++i)
    if (map.models[i].T_w_m) posed.push_back(static_cast<int>(i));
  const auto camera = std::make_shared<const Camera>(map.camera);
  CameraTrajectory some;
  const std::size_t n = std::min(kMostViews, posed.size());
  for (std::size_t i = 0; i < n; ++i) {
    const int number = posed[i * posed.size() / n];
    const LocalModel& model = map.models[static_cast<std::size_t>(number)];
    const auto view = std::make_shared<View>(*map.view(number));
    if (!view->camera) view->camera = camera;
    some.images.push_back({model.stamp, *model.T_w_m, static_cast<int>(i)});
    some.keyframes.push_back({i, view, {*model.T_w_m, Matrix6d::Zero()}, 0});
  }
  return some;
}

/** Alignment of a map with those before it. */
MapAlignment alignmentOf(const std::vector<Map>& maps, std::size_t number, int threads,
                         const MapProgressCallback& progress) {
  MapAlignment alignment;
  if (!hasPoses(maps[number])) return alignment;
  const CameraTrajectory views = someViews(maps[number]);
  for (std::size_t k = 0; k < number; ++k) {
    if (!hasPoses(maps[k])) continue;
    const GlobalLocalization localization(unowned(maps[k]));
    const SessionPlace place =
        placeRigidly(localization, views, MapBuilderParams(), MapSessionParams(), threads, progress);
    alignment.tried.emplace_back(k, place);
    if (!place.found()) continue;
    alignment.T_new_old = *place.T_w_k.front() * views.keyframes.front().T_w_c.T.inverse();
    alignment.moved = !isNear(alignment.T_new_old, Eigen::Isometry3d::Identity(), 1e-9, 1e-6);
    break;
  }
  return alignment;
}

void appendMap(const Map& map, const std::string& prefix, const std::set<std::string>& ambiguous,
               Map& merged) {
  const int offset = static_cast<int>(merged.models.size());
  const std::vector<char> rendered = renderedViews(map);
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    LocalModel model = map.models[i];
    if (ambiguous.count(model.name)) model.name = prefix + "_" + model.name;
    if (rendered[i]) merged.meta[kRenderedKey] += model.name + "\n";
    merged.models.push_back(std::move(model));
  }
  for (Link link : map.links) {
    link.from += offset;
    link.to += offset;
    merged.links.push_back(link);
  }
}

bool sameMounting(const std::optional<CameraMounting>& a, const std::optional<CameraMounting>& b) {
  return a && b ? a->agreesWith(*b) : !a && !b;
}

std::set<std::string> ambiguousNames(const std::vector<Map>& maps) {
  std::set<std::string> seen, ambiguous;
  for (const Map& map : maps)
    for (const LocalModel& model : map.models)
      if (!seen.insert(model.name).second) ambiguous.insert(model.name);
  return ambiguous;
}

void requireUniqueNames(const Map& map) {
  std::set<std::string> names;
  for (const LocalModel& model : map.models)
    if (!names.insert(model.name).second)
      throw std::invalid_argument(fmt::format(
          "two local models would be named {}; rename the maps so that their names differ", model.name));
}

/** A surface that one of the maps lacks contradicts nothing; surfaces are fixed if those of all maps are. */
MapSurfaces surfacesOfAll(const std::vector<Map>& maps) {
  if (std::any_of(maps.begin(), maps.end(), lacksSurfaces)) return MapSurfaces::incomplete;
  const auto isFixed = [](const Map& map) { return surfacesOf(map) == MapSurfaces::fixed; };
  return std::all_of(maps.begin(), maps.end(), isFixed) ? MapSurfaces::fixed : MapSurfaces::seen;
}

}  // namespace

std::vector<MapAlignment> alignMaps(std::vector<Map>& maps, int threads,
                                    const MapProgressCallback& progress) {
  std::vector<MapAlignment> alignments;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    alignments.push_back(alignmentOf(maps, i, threads, progress));
    const MapAlignment& alignment = alignments.back();
    if (alignment.isLost()) break;
    if (!alignment.moved) continue;
    for (LocalModel& model : maps[i].models)
      if (model.T_w_m) model.T_w_m = alignment.T_new_old * *model.T_w_m;
  }
  return alignments;
}

Map mergedMap(const std::vector<Map>& maps, const std::vector<std::string>& names) {
  const std::set<std::string> ambiguous = ambiguousNames(maps);
  Map merged;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    appendMap(maps[i], names[i], ambiguous, merged);
    const Camera& camera = maps[i].camera;
    if (i == 0) merged.camera = camera;
    // One camera's field differs a little from map to map; of two cameras one has to be chosen.
    if (!merged.camera.distortion) merged.camera.distortion = camera.distortion;
    if (!sameMounting(merged.camera.mounting, camera.mounting)) merged.camera.mounting.reset();
    const auto same = std::count(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]);
    const std::string prefix = same > 0 ? fmt::format("{}_{}.", names[i], same + 1) : names[i] + ".";
    for (const auto& [key, value] : maps[i].meta)
      if (key != kSureKey && key != kRenderedKey && key != kConsideredErrorsKey)
        merged.meta[prefix + key] = value;
    const auto errors = maps[i].meta.find(kConsideredErrorsKey);
    if (errors != maps[i].meta.end() && consideredErrorsOf(maps[i]).views == 0) merged.meta.insert(*errors);
  }
  setSurfaces(surfacesOfAll(maps), merged);
  requireUniqueNames(merged);
  placeByLinks(merged);
  return merged;
}

}  // namespace facetloc
