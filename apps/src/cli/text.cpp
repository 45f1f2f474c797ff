// SPDX-License-Identifier: BSD-3-Clause
#include "cli/text.h"

#include <algorithm>
#include <fmt/core.h>

namespace facetloc {
namespace {

/** Characters on the screen: continuation bytes of UTF-8 take no room. */
std::size_t displayWidth(const std::string& text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

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

std::string printable(std::string_view text) {
  // Those of ASCII, and those that UTF-8 writes as C2 80 to C2 9F.
  const auto isControl = [](unsigned char c) { return (c < 0x20 && c != '\n' && c != '\t') || c == 0x7F; };
  std::string shown;
  for (std::size_t i = 0; i < text.size(); ++i) {
    auto c = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
    const bool is_pair = c == 0xC2 && next >= 0x80 && next <= 0x9F;
    if (is_pair) c = next, ++i;
    shown += is_pair || isControl(c) ? fmt::format("\\x{:02x}", c) : std::string(1, text[i]);
  }
  return shown;
}

std::string counted(std::size_t n, const std::string& noun) {
  return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s");
}

TextTable::TextTable(std::vector<std::string> header) { rows_.push_back(std::move(header)); }

void TextTable::add(std::vector<std::string> row) {
  row.resize(rows_.front().size());
  rows_.push_back(std::move(row));
}

std::ostream& operator<<(std::ostream& out, const TextTable& table) {
  const std::size_t columns = table.rows_.front().size();
  std::vector<std::size_t> widths(columns, 0);
  for (const auto& row : table.rows_)
    for (std::size_t c = 0; c < columns; ++c) widths[c] = std::max(widths[c], displayWidth(row[c]));
  for (const auto& row : table.rows_) {
    std::string line;
    for (std::size_t c = 0; c < columns; ++c) {
      const bool words = c == 0 || (table.words_last_ && c + 1 == columns);
      const std::string blank(widths[c] - displayWidth(row[c]), ' ');
      line += (c ? "  " : "") + (words ? row[c] + blank : blank + row[c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out << line << "\n";
  }
  return out;
}

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
