// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/rendered_views.h>

#include <set>
#include <sstream>
#include <string>

namespace facetloc {

std::vector<char> renderedViews(const Map& map) {
  std::set<std::string> names;
  if (const auto found = map.meta.find(kRenderedKey); found != map.meta.end()) {
    std::istringstream lines(found->second);
    for (std::string name; std::getline(lines, name);) names.insert(name);
  }
  std::vector<char> rendered;
  rendered.reserve(map.models.size());
  for (const LocalModel& model : map.models) rendered.push_back(names.count(model.name) > 0);
  return rendered;
}

}  // namespace facetloc
