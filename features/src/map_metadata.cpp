// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"

#include <facetloc/features/answer_state.h>
#include <facetloc/features/map_metadata.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <set>
#include <sstream>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr const char* kFixed = "fixed";
constexpr const char* kIncomplete = "incomplete";

/** Null for a map without this key. */
const std::string* metaOf(const Map& map, const char* key) {
  const auto found = map.meta.find(key);
  return found == map.meta.end() ? nullptr : &found->second;
}

constexpr std::array<const char*, 6> kNames = {"min_probability", "alpha", "confidence",
                                               "images",          "sure",  "wrong"};
constexpr std::string_view kFrom = " from ";

constexpr std::array<const char*, 4> kErrorNames = {"pixels_as_one", "rotation_deg", "translation", "views"};
constexpr const char* kThreshold = "the threshold of sure answers";
constexpr const char* kErrors = "the considered errors";

[[noreturn]] void fail(const std::string& of, const std::string& cause) {
  throw std::invalid_argument(of + " in its meta data " + cause);
}

/** Reads "name=number". */
template <class Number>
Number value(const char* of, std::string_view word, const char* name) {
  const std::string prefix = std::string(name) + "=";
  const auto number = word.substr(0, prefix.size()) == prefix ? text::to<Number>(word.substr(prefix.size()))
                                                              : std::optional<Number>();
  if (!number) fail(of, fmt::format("has no {}", name));
  return *number;
}

void requirePossible(const SureThreshold& t) {
  const auto isShare = [](double p) { return p > 0 && p < 1; };
  const bool possible = t.min_probability > 0 && t.min_probability <= 1 && isShare(t.alpha) &&
                        isShare(t.confidence) && t.wrong >= 0 && t.wrong <= t.sure && t.sure <= t.images;
  if (!possible) fail(kThreshold, "is impossible");
}

void requirePossible(const ConsideredErrors& e) {
  const auto isSize = [](double x) { return x > 1e-9 && x < 1e9; };  // its square and inverse are usable
  if (!isSize(e.pixels_as_one) || !isSize(e.rotation_std) || !isSize(e.translation_std) || e.views < 0)
    fail(kErrors, "are impossible");
}

}  // namespace

MapSurfaces surfacesOf(const Map& map) {
  const std::string* kind = metaOf(map, kSurfacesKey);
  return !kind                  ? MapSurfaces::seen
         : *kind == kFixed      ? MapSurfaces::fixed
         : *kind == kIncomplete ? MapSurfaces::incomplete
                                : MapSurfaces::seen;
}

void setSurfaces(MapSurfaces surfaces, Map& map) {
  if (surfaces == MapSurfaces::seen)
    map.meta.erase(kSurfacesKey);
  else
    map.meta[kSurfacesKey] = surfaces == MapSurfaces::fixed ? kFixed : kIncomplete;
}

std::vector<char> renderedViews(const Map& map) {
  std::set<std::string> names;
  if (const std::string* all = metaOf(map, kRenderedKey)) {
    std::istringstream lines(*all);
    for (std::string name; std::getline(lines, name);) names.insert(name);
  }
  std::vector<char> rendered;
  rendered.reserve(map.models.size());
  for (const LocalModel& model : map.models) rendered.push_back(names.count(model.name) > 0);
  return rendered;
}

std::string SureThreshold::toString() const {
  return fmt::format(
      "p >= {}: at most {} % of the sure answers are wrong, with {} % confidence; {} of {} images of {} are "
      "sure, {} of these wrong",
      text::shortest(min_probability), fmt::format("{:.4g}", 100 * alpha),
      fmt::format("{:.4g}", 100 * confidence), sure, images, source, wrong);
}

std::string toText(const SureThreshold& t) {
  requirePossible(t);
  std::string source = t.source;
  std::replace(source.begin(), source.end(), '\n', ' ');
  return fmt::format("min_probability={} alpha={} confidence={} images={} sure={} wrong={}{}{}",
                     text::shortest(t.min_probability), text::shortest(t.alpha), text::shortest(t.confidence),
                     t.images, t.sure, t.wrong, kFrom, source);
}

std::optional<SureThreshold> sureThresholdOf(const Map& map) {
  const std::string* line = metaOf(map, kSureKey);
  if (!line) return {};
  const std::string_view all = *line;
  const auto end = all.find(kFrom);
  const auto words = text::words(all.substr(0, end));
  if (end == std::string_view::npos || words.size() != kNames.size()) fail(kThreshold, "is malformed");
  SureThreshold t;
  t.min_probability = value<double>(kThreshold, words[0], kNames[0]);
  t.alpha = value<double>(kThreshold, words[1], kNames[1]);
  t.confidence = value<double>(kThreshold, words[2], kNames[2]);
  t.images = value<int>(kThreshold, words[3], kNames[3]);
  t.sure = value<int>(kThreshold, words[4], kNames[4]);
  t.wrong = value<int>(kThreshold, words[5], kNames[5]);
  t.source = all.substr(end + kFrom.size());
  requirePossible(t);
  return t;
}

std::string ConsideredErrors::toString() const {
  return fmt::format("{:.2g} deg, {:.2g} mm, and {:.2g} pixels as one; {}", rotation_std / kDegree,
                     1e3 * translation_std, pixels_as_one,
                     views > 0 ? fmt::format("from {} of its views", views) : "as usual");
}

std::string toText(const ConsideredErrors& e) {
  requirePossible(e);
  return fmt::format("{}={:.4g} {}={:.4g} {}={:.4g} {}={}", kErrorNames[0], e.pixels_as_one, kErrorNames[1],
                     e.rotation_std / kDegree, kErrorNames[2], e.translation_std, kErrorNames[3], e.views);
}

ConsideredErrors consideredErrorsOf(const Map& map) {
  const std::string* line = metaOf(map, kConsideredErrorsKey);
  if (!line) return {};
  const auto words = text::words(*line);
  if (words.size() != kErrorNames.size()) fail(kErrors, "are malformed");
  ConsideredErrors e;
  e.pixels_as_one = value<double>(kErrors, words[0], kErrorNames[0]);
  e.rotation_std = value<double>(kErrors, words[1], kErrorNames[1]) * kDegree;
  e.translation_std = value<double>(kErrors, words[2], kErrorNames[2]);
  e.views = value<int>(kErrors, words[3], kErrorNames[3]);
  requirePossible(e);
  return e;
}

double minProbabilityOf(const Map& map) {
  const auto threshold = sureThresholdOf(map);
  return threshold ? threshold->min_probability : kMinProbability;
}

}  // namespace facetloc
