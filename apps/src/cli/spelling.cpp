// SPDX-License-Identifier: BSD-3-Clause
#include "cli/spelling.h"

#include <algorithm>
#include <fmt/format.h>

namespace facetloc {
namespace {

constexpr std::size_t kCharactersPerError = 3;

/** Number of characters to insert, remove, replace, or swap with their neighbour, to make one word of the
 * other. */
std::size_t spellingDistance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t k = 0; k <= b.size(); ++k) {
      if (i == 0 || k == 0) {
        d[i][k] = i + k;
        continue;
      }
      d[i][k] = std::min({d[i - 1][k] + 1, d[i][k - 1] + 1, d[i - 1][k - 1] + (a[i - 1] != b[k - 1])});
      if (i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1])
        d[i][k] = std::min(d[i][k], d[i - 2][k - 2] + 1);
    }
  return d[a.size()][b.size()];
}

std::size_t distanceOf(const std::string& word, const std::string& known) {
  const std::size_t whole = spellingDistance(word, known);
  const auto dot = known.rfind('.');
  return dot == std::string::npos ? whole : std::min(whole, spellingDistance(word, known.substr(dot + 1)));
}

}  // namespace

std::string underscored(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::string nearestWord(const std::string& word, const std::vector<std::string>& known) {
  constexpr std::size_t kLongest = 100;  // Longer words get no suggestion.
  if (word.size() > kLongest) return {};
  std::string nearest;
  std::size_t least = word.size() / kCharactersPerError + 1;
  for (const std::string& name : known)
    if (const std::size_t distance = distanceOf(underscored(word), underscored(name)); distance < least) {
      least = distance;
      nearest = name;
    }
  return nearest;
}

std::string didYouMean(const std::string& word, const std::vector<std::string>& known,
                       const std::string& prefix) {
  const std::string nearest = nearestWord(word, known);
  return nearest.empty() ? "" : fmt::format("; did you mean '{}{}'?", prefix, nearest);
}

}  // namespace facetloc
