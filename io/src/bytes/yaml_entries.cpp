// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/yaml_entries.h"

#include "base/text.h"

#include <algorithm>
#include <cctype>
#include <utility>

namespace facetloc::internal {
namespace {

/** The keys in their order, whatever their nesting. */
class Scanner {
public:
  explicit Scanner(std::string_view text) : text_(text) {}

  std::vector<YamlEntry> scan() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#' || c == '%')
        skipLine();
      else if (c == '"' || c == '\'')
        take(quoted(c));
      else if (isOfWord(c))
        take(word());
      else
        ++at_;
    }
    return entries_;
  }

private:
  static bool isOfWord(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '-' || c == '+' ||
           c == '/' || c == '!';
  }

  void skipLine() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  }
  std::string_view quoted(char quote) {
    const std::size_t begin = ++at_;
    while (at_ < text_.size() && text_[at_] != quote && text_[at_] != '\n') ++at_;
    const std::string_view found = text_.substr(begin, at_ - begin);
    if (at_ < text_.size()) ++at_;
    return found;
  }
  std::string_view word() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && isOfWord(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }

  bool isKey() {
    std::size_t next = at_;
    while (next < text_.size() && (text_[next] == ' ' || text_[next] == '\t')) ++next;
    return next < text_.size() && text_[next] == ':';
  }

  void take(std::string_view part) {
    if (isKey()) {
      YamlEntry entry;
      for (const char c : part.substr(part.find_last_of("./") + 1))
        entry.key += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      entry.end = static_cast<std::size_t>(part.data() + part.size() - text_.data());
      entries_.push_back(std::move(entry));
    } else if (!entries_.empty()) {
      std::string_view digits = part;
      if (digits.size() > 1 && digits.back() == '.') digits.remove_suffix(1);  // OpenCV's "0."
      if (const auto number = text::to<double>(digits))
        entries_.back().numbers.push_back(*number);
      else if (part.rfind("!!", 0) != 0)
        entries_.back().word = part;
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::vector<YamlEntry> entries_;
};

}  // namespace

std::vector<YamlEntry> yamlEntries(std::string_view text) { return Scanner(text).scan(); }

std::string_view lineBehind(const YamlEntry& entry, std::string_view text) {
  std::string_view line = text.substr(std::min(entry.end, text.size()));
  line = line.substr(0, line.find('\n'));
  const auto colon = line.find(':');
  if (colon == std::string_view::npos) return {};
  line = text::trimmed(line.substr(colon + 1));
  if (!line.empty() && (line.front() == '"' || line.front() == '\'')) {
    const auto close = line.find(line.front(), 1);
    return line.substr(1, close == std::string_view::npos ? close : close - 1);
  }
  return text::trimmed(line.substr(0, line.find(" #")));
}

}  // namespace facetloc::internal
