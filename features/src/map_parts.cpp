// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/map_metadata.h>
#include <facetloc/features/map_parts.h>

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <queue>
#include <set>
#include <stdexcept>
#include <utility>

namespace facetloc {
namespace {

constexpr double kLever = 3;  // typical distance to the surfaces that a depth camera sees [m]
constexpr double kUnreached = std::numeric_limits<double>::infinity();

/** The way along a link, in either direction. */
struct Way {
  std::size_t to;
  double cost;
  Eigen::Isometry3d T_from_to;
};

/** Places models one after the other: those with the shortest path from any that has a pose first. */
class Placing {
public:
  explicit Placing(Map& map) : map_(map), ways_(map.models.size()), cost_(map.models.size(), kUnreached) {
    for (const Link& link : map.links) add(link);
  }

  bool isPlaced(std::size_t model) const { return cost_[model] < kUnreached; }

  /** A model whose T_w_m and part are known. */
  void addSource(std::size_t model) {
    cost_[model] = 0;
    next_.push({0, model});
  }

  /** Everything that a path leads to. */
  void spread() {
    while (!next_.empty()) {
      const auto [cost, from] = next_.top();
      next_.pop();
      if (cost > cost_[from]) continue;  // a shorter path was found since
      for (const Way& way : ways_[from]) {
        if (!(cost + way.cost < cost_[way.to])) continue;
        cost_[way.to] = cost + way.cost;
        next_.push({cost_[way.to], way.to});
        LocalModel& model = map_.models[way.to];
        // Orthonormal, however long the path.
        model.T_w_m = boxplus(*map_.models[from].T_w_m * way.T_from_to, Vector6d::Zero());
        model.part = map_.models[from].part;
        model.by_links = true;
      }
    }
  }

private:
  bool isModel(int i) const { return i >= 0 && static_cast<std::size_t>(i) < map_.models.size(); }

  void add(const Link& link) {
    if (!isModel(link.from) || !isModel(link.to)) return;
    const double cost = uncertaintyOf(link);
    if (!(cost >= 0 && cost < kUnreached) || !link.T_from_to.T.matrix().allFinite()) return;
    const auto from = static_cast<std::size_t>(link.from), to = static_cast<std::size_t>(link.to);
    ways_[from].push_back({to, cost, link.T_from_to.T});
    ways_[to].push_back({from, cost, link.T_from_to.T.inverse()});
  }

  using Reached = std::pair<double, std::size_t>;  // cost and model; of equal costs the first in the map

  Map& map_;
  std::vector<std::vector<Way>> ways_;  // indexed by the model where they begin
  std::vector<double> cost_;            // cost of each model's best path so far
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next_;
};

/** Pose of the first model of a part: up is up, if that is known. */
Eigen::Isometry3d firstPose(const Map& map) {
  return map.camera.mounting ? map.camera.mounting->T_b_c() : Eigen::Isometry3d::Identity();
}

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

double uncertaintyOf(const Link& link) {
  const Matrix6d& P = link.T_from_to.P;
  return kLever * kLever * P.topLeftCorner<3, 3>().trace() + P.bottomRightCorner<3, 3>().trace();
}

void placeByLinks(Map& map) {
  map.parts.clear();
  for (LocalModel& model : map.models) {
    model.T_w_m = model.givenPose();
    model.by_links = false;
    model.part = 0;
  }
  Placing placing(map);
  for (std::size_t i = 0; i < map.models.size(); ++i)
    if (map.models[i].T_w_m) placing.addSource(i);
  const bool any_given = hasGivenPose(map);
  if (any_given) map.parts.emplace_back();
  placing.spread();
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    if (placing.isPlaced(i)) continue;
    LocalModel& first = map.models[i];
    first.T_w_m = firstPose(map);
    first.part = static_cast<int>(map.parts.size());
    first.by_links = true;
    map.parts.push_back(first.name.empty() ? fmt::format("part {}", first.part) : first.name);
    placing.addSource(i);
    placing.spread();
  }
  if (!any_given && map.parts.size() == 1) map.parts.front().clear();
}

bool hasGivenPose(const Map& map) {
  return std::any_of(map.models.begin(), map.models.end(),
                     [](const LocalModel& m) { return m.givenPose().has_value(); });
}

std::vector<PartCount> partCounts(const Map& map) {
  std::vector<PartCount> counts(std::max<std::size_t>(1, map.parts.size()));
  for (const LocalModel& model : map.models) {
    PartCount& count = counts[static_cast<std::size_t>(model.part)];
    ++count.models;
    count.by_links += model.by_links;
  }
  return counts;
}

int mainPart(const Map& map) {
  if (map.parts.empty() || map.parts.front().empty()) return 0;
  const std::vector<PartCount> counts = partCounts(map);
  const auto largest =
      std::max_element(counts.begin(), counts.end(),
                       [](const PartCount& a, const PartCount& b) { return a.models < b.models; });
  return static_cast<int>(largest - counts.begin());
}

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
