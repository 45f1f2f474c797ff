// SPDX-License-Identifier: BSD-3-Clause
#include "tools/text.h"

#include <facetloc/io/text.h>

#include <algorithm>

namespace facetloc {
namespace {

/** Characters on the screen: continuation bytes of UTF-8 take no room. */
std::size_t displayWidth(const std::string& text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

}  // namespace

std::string counted(std::size_t n, const std::string& noun) {
  return std::to_string(n) + " " + noun + (n == 1 ? "" : "s");
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

}  // namespace facetloc
