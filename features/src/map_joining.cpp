// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/map_metadata.h>
#include <facetloc/features/map_parts.h>

#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <stdexcept>
#include <utility>

namespace facetloc {
namespace {

void check(const std::vector<JoinedMap>& maps) {
  if (maps.empty()) throw std::invalid_argument("no map is to be joined");
  std::set<std::string> names;
  for (const JoinedMap& one : maps) {
    if (one.name.empty() || one.name.find('/') != std::string::npos)
      throw std::invalid_argument(fmt::format("'{}' is no name for a map among several", one.name));
    if (!names.insert(one.name).second)
      throw std::invalid_argument(fmt::format("two maps are named '{}': rename a file", one.name));
    if (surfacesOf(*one.map) != surfacesOf(*maps.front().map))
      throw std::invalid_argument(fmt::format(
          "'{}' holds surfaces of another kind than '{}': maps of plans, models and images are not judged "
          "together",
          one.name, maps.front().name));
  }
}

/** "ground" for its world, "ground/cellar" for another part or a local model. */
std::string within(const std::string& map, const std::string& name) {
  return name.empty() ? map : map + "/" + name;
}

void addMap(const JoinedMap& one, Map& all) {
  const int first_model = static_cast<int>(all.models.size());
  const std::vector<char> rendered = renderedViews(*one.map);
  for (std::size_t i = 0; i < one.map->models.size(); ++i) {
    LocalModel model = one.map->models[i];
    model.name = within(one.name, model.name);
    model.part += one.first_part;
    if (rendered[i]) all.meta[kRenderedKey] += model.name + "\n";
    all.models.push_back(std::move(model));
  }
  for (Link link : one.map->links) {
    link.from += first_model, link.to += first_model;
    all.links.push_back(link);
  }
  const std::vector<std::string> world = {""};
  for (const std::string& part : one.map->parts.empty() ? world : one.map->parts)
    all.parts.push_back(within(one.name, part));
}

/** \param worst of two values in the meta data of maps */
template <class Value, class Worst>
Value worstOf(const std::vector<JoinedMap>& maps, Value (*of_map)(const Map&), Worst&& worst) {
  Value out = of_map(*maps.front().map);
  for (const JoinedMap& one : maps) out = worst(out, of_map(*one.map));
  return out;
}

ConsideredErrors larger(const ConsideredErrors& a, const ConsideredErrors& b) {
  return {std::max(a.pixels_as_one, b.pixels_as_one), std::max(a.rotation_std, b.rotation_std),
          std::max(a.translation_std, b.translation_std), std::max(a.views, b.views)};
}

std::optional<SureThreshold> higher(const std::optional<SureThreshold>& a,
                                    const std::optional<SureThreshold>& b) {
  return !a || (b && b->min_probability > a->min_probability) ? b : a;
}

}  // namespace

Map joinMaps(std::vector<JoinedMap> maps) {
  check(maps);
  Map all;
  all.camera = maps.front().map->camera;
  for (JoinedMap& one : maps) {
    one.first_part = static_cast<int>(all.parts.size());
    addMap(one, all);
    if (!one.map->camera.mounting ||
        (all.camera.mounting && !differenceOf(one.map->camera, all.camera).sameMounting()))
      all.camera.mounting.reset();
  }
  setSurfaces(surfacesOf(*maps.front().map), all);
  all.meta[kConsideredErrorsKey] = toText(worstOf(maps, &consideredErrorsOf, larger));
  if (const auto sure = worstOf(maps, &sureThresholdOf, higher)) all.meta[kSureKey] = toText(*sure);
  all.joined = std::move(maps);
  return all;
}

}  // namespace facetloc
