// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/** \file
 * Text in and out: numbers never depend on the locale. */

namespace facetloc::text {

constexpr std::string_view kBlank = " \t\r\n\v\f";
constexpr int kPoseDigits = 9;  ///< significant digits of poses, covariances and scores in text files

/** \brief Without the blanks around it. */
inline std::string_view trimmed(std::string_view s) {
  const auto first = s.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(kBlank) - first + 1);
}

/** \brief The text before the first comment character. */
inline std::string_view withoutComment(std::string_view line) { return line.substr(0, line.find('#')); }

/** \brief The parts between separators, one more than these. */
inline std::vector<std::string_view> split(std::string_view s, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto end = s.find(separator);
    parts.push_back(s.substr(0, end));
    if (end == std::string_view::npos) return parts;
    s.remove_prefix(end + 1);
  }
}

inline std::vector<std::string_view> lines(std::string_view s) { return split(s, '\n'); }

/** \brief The words between blanks. */
inline std::vector<std::string_view> words(std::string_view s) {
  std::vector<std::string_view> found;
  for (auto first = s.find_first_not_of(kBlank); first != std::string_view::npos;) {
    const auto end = std::min(s.find_first_of(kBlank, first), s.size());
    found.push_back(s.substr(first, end - first));
    first = s.find_first_not_of(kBlank, end);
  }
  return found;
}

/** \brief The number that a text is, and nothing but it. */
template <typename Number>
std::optional<Number> to(std::string_view s) {
  if (s.size() > 1 && s[0] == '+' && s[1] != '-') s.remove_prefix(1);  // from_chars knows no plus
  Number value{};
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), value);
  if (error != std::errc() || end != s.data() + s.size()) return {};
  return value;
}

/** \brief As std::to_chars, which takes the format. */
template <typename... Format>
std::string printed(double value, Format... format) {
  // Room for the longest double in fixed notation. Adding zero makes -0 positive.
  std::array<char, 400> buffer;
  return {buffer.data(),
          std::to_chars(buffer.data(), buffer.data() + buffer.size(), value + 0.0, format...).ptr};
}

/** \brief As few digits as read back to the same double. */
inline std::string shortest(double value) { return printed(value); }
/** \brief As printf("%.*g"). */
inline std::string significant(double value, int digits = kPoseDigits) {
  return printed(value, std::chars_format::general, digits);
}
/** \brief As printf("%.*f"). */
inline std::string decimals(double value, int digits) {
  return printed(value, std::chars_format::fixed, digits);
}

/** \brief A cell of a CSV file, in quotes if it has to be (RFC 4180). */
inline std::string csvCell(const std::string& s) {
  if (s.find_first_of(",\"\r\n") == std::string::npos) return s;
  std::string out = "\"";
  for (const char c : s) out.append(c == '"' ? 2 : 1, c);
  return out + "\"";
}

/** \brief Text in quotes, for messages. */
inline std::string quoted(std::string_view s) { return "'" + std::string(s) + "'"; }

/** \brief Text in lower case, as far as its letters are ASCII. */
inline std::string lower(std::string s) {
  for (char& c : s)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return s;
}

/** \brief ".png" of a.PNG. */
inline std::string lowerExtension(const std::filesystem::path& path) {
  return lower(path.extension().string());
}

}  // namespace facetloc::text
