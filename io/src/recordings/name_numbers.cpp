// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/name_numbers.h"

#include "base/median.h"
#include "base/text.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <ctime>
#include <fmt/format.h>
#include <map>
#include <regex>
#include <set>
#include <utility>

namespace facetloc::internal {
namespace {

bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool isLower(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }
bool isUpper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }

/** Seconds since 1970 of a date and time in a name, as if its clock had shown universal time:
 * 20121214T142255.814212, 2023-05-14_10-12-33, 2023.05.14 10:12:33,25. */
std::optional<double> secondsOfDate(const std::string& name) {
  static const std::regex date(
      R"((^|\D)((?:19|20)\d\d)([-_.:]?)(\d\d)\3(\d\d)[-T_ .]{0,4}(\d\d)([-_.:]?)(\d\d)\7(\d\d))"
      R"((?:[.,](\d{1,9}))?(?![\dA-Za-z]|[.,]\d))");
  std::smatch parts;
  if (!std::regex_search(name, parts, date)) return {};
  const auto number = [&parts](int k) { return std::stoi(parts[k].str()); };
  std::tm time{};
  time.tm_year = number(2) - 1900, time.tm_mon = number(4) - 1, time.tm_mday = number(5);
  time.tm_hour = number(6), time.tm_min = number(8), time.tm_sec = number(9);
  const std::tm asked = time;
  const std::time_t seconds = timegm(&time);
  if (time.tm_mon != asked.tm_mon || time.tm_mday != asked.tm_mday || asked.tm_hour > 23 ||
      asked.tm_min > 59 || asked.tm_sec > 60)
    return {};
  return static_cast<double>(seconds) + text::to<double>("0." + parts[10].str() + "0").value_or(0);
}

/** A name as texts and numbers in turn: one text more than numbers. */
struct Pieces {
  std::vector<std::string> texts, numbers;
};

Pieces piecesOf(const std::string& name) {
  Pieces pieces;
  std::string text;
  for (std::size_t i = 0; i < name.size();) {
    if (!isDigit(name[i])) {
      text += name[i++];
      continue;
    }
    std::size_t end = i;
    bool has_point = false;
    while (end < name.size() && (isDigit(name[end]) || (name[end] == '.' && !has_point &&
                                                        end + 1 < name.size() && isDigit(name[end + 1])))) {
      has_point = has_point || name[end] == '.';
      ++end;
    }
    pieces.texts.push_back(std::exchange(text, {}));
    pieces.numbers.push_back(name.substr(i, end - i));
    i = end;
  }
  pieces.texts.push_back(text);
  return pieces;
}

/** Which of the numbers of otherwise equal names differs from name to name, one with a point rather
 * than another; of a single name the only one. Nothing if the names differ otherwise, or not by a
 * number. */
std::optional<std::size_t> counting(const std::vector<Pieces>& names) {
  const Pieces& first = names.front();
  if (first.numbers.empty()) return {};
  for (const Pieces& name : names)
    if (name.texts != first.texts) return {};
  if (names.size() == 1) return first.numbers.size() == 1 ? std::optional<std::size_t>(0) : std::nullopt;
  std::optional<std::size_t> found;
  for (std::size_t k = 0; k < first.numbers.size(); ++k) {
    std::vector<std::string> values;
    for (const Pieces& name : names) values.push_back(name.numbers[k]);
    std::sort(values.begin(), values.end());
    if (std::adjacent_find(values.begin(), values.end()) != values.end()) continue;
    if (first.numbers[k].find('.') != std::string::npos) return k;
    if (!found) found = k;
  }
  return found;
}

bool isPadded(const std::string& number) {
  return number.size() > 1 && number[0] == '0' && number.find('.') == std::string::npos;
}

constexpr double kNanoseconds = 1e-9, kMicroseconds = 1e-6, kMilliseconds = 1e-3;
constexpr double kFirstEpoch = 1e9, kLastEpoch = 2.5e9;  // [s] of clocks since 1970: from 2001 to 2049

/** Without those that are zero. */
std::vector<double> stepsOf(std::vector<double> numbers) {
  std::sort(numbers.begin(), numbers.end());
  std::vector<double> steps;
  for (std::size_t i = 1; i < numbers.size(); ++i)
    if (numbers[i] > numbers[i - 1]) steps.push_back(numbers[i] - numbers[i - 1]);
  return steps;
}

bool areWhole(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double n) { return n == std::floor(n); });
}

template <typename Condition>
bool mostOf(const std::vector<double>& values, Condition holds) {
  return 2 * std::count_if(values.begin(), values.end(), holds) >= static_cast<std::ptrdiff_t>(values.size());
}

/** True for a clock with the steps of a camera, 33, 34, 33; not 10, 10, 20 of each tenth image. */
bool jitter(const std::vector<double>& steps) {
  constexpr double kShortest = 5, kLongest = 1000, kNear = 0.2;
  constexpr std::size_t kEnough = 3;
  if (steps.size() < kEnough) return false;
  const double usual = internal::median(steps);
  if (usual < kShortest || usual > kLongest) return false;
  const bool multiples =
      std::all_of(steps.begin(), steps.end(), [&](double s) { return std::fmod(s, usual) == 0; });
  return !multiples && mostOf(steps, [&](double s) { return std::abs(s - usual) <= kNear * usual; });
}

}  // namespace

std::string numbersOf(const std::string& name) {
  return fmt::format("{}", fmt::join(piecesOf(name).numbers, " "));
}

std::vector<std::size_t> seriesInNames(const std::vector<std::string>& names) {
  constexpr std::size_t kMostCameras = 8, kMostSlots = 16;
  std::vector<Pieces> pieces;
  std::size_t slots = 0;  // numbers that all names have; one slot more stands for their words
  for (const std::string& name : names) {
    pieces.push_back(piecesOf(name));
    slots = pieces.size() == 1 ? pieces[0].numbers.size() : std::min(slots, pieces.back().numbers.size());
  }
  slots = std::min(slots, kMostSlots);
  for (std::size_t slot = 0; slot <= slots; ++slot) {
    std::map<std::string, std::size_t> series;                 // keyed by the word or number of the slot
    std::map<std::string, std::set<std::size_t>> series_with;  // the other pieces
    std::vector<std::size_t> of_names;
    for (const Pieces& name : pieces) {
      Pieces others = name;
      const bool of_words = slot == slots;
      const std::string value =
          of_words ? fmt::format("{}", fmt::join(name.texts, "#")) : std::exchange(others.numbers[slot], {});
      if (of_words) others.texts.clear();
      of_names.push_back(series.emplace(value, series.size()).first->second);
      series_with[fmt::format("{}#{}", fmt::join(others.texts, "#"), fmt::join(others.numbers, " "))].insert(
          of_names.back());
    }
    const auto in_all = std::count_if(series_with.begin(), series_with.end(), [&](const auto& other) {
      return other.second.size() == series.size();
    });
    const bool may_count = slot == slots || std::all_of(series.begin(), series.end(), [](const auto& camera) {
                             return camera.first.size() == 1;  // no seconds, no fractions of one
                           });
    const bool repeats = may_count && series.size() > 1 && series.size() <= kMostCameras && in_all > 1 &&
                         series.size() < series_with.size() &&
                         2 * in_all > static_cast<std::ptrdiff_t>(series_with.size());
    if (repeats) return of_names;
  }
  return std::vector<std::size_t>(names.size());
}

std::optional<double> stampInName(const std::string& name) {
  if (const auto seconds = secondsOfDate(name)) return seconds;
  const auto number = text::to<double>(name);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::optional<NameNumbers> numbersInNames(const std::vector<std::string>& names) {
  if (names.empty()) return {};
  NameNumbers found;
  for (const std::string& name : names) {
    const auto stamp = stampInName(name);
    if (!stamp) break;
    found.numbers.push_back(*stamp);
    found.decimal = found.decimal || name.find_first_of(".eE") != std::string::npos || secondsOfDate(name);
    found.padded = found.padded || isPadded(name);
  }
  if (found.numbers.size() == names.size()) return found;
  std::vector<Pieces> pieces;
  for (const std::string& name : names) pieces.push_back(piecesOf(name));
  const auto k = counting(pieces);
  if (!k) return {};
  found = {};
  for (const Pieces& name : pieces) {
    const auto number = text::to<double>(name.numbers[*k]);
    if (!number) return {};
    found.numbers.push_back(*number);
    found.decimal = found.decimal || name.numbers[*k].find('.') != std::string::npos;
    found.padded = found.padded || isPadded(name.numbers[*k]);
  }
  return found;
}

bool hasWord(const std::string& name, const std::string& word) {
  const auto isLetter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  const std::string folded = text::lower(name);
  for (auto at = folded.find(word); at != std::string::npos; at = folded.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    const bool begins = at == 0 || !isLetter(name[at - 1]) || (isLower(name[at - 1]) && isUpper(name[at]));
    const bool ends =
        end == name.size() || !isLetter(name[end]) || (isLower(name[end - 1]) && isUpper(name[end]));
    if (begins && ends) return true;
  }
  return false;
}

std::string TimeUnit::toString() const {
  if (counted) return "numbers";
  if (seconds == kNanoseconds) return "nanoseconds";
  if (seconds == kMicroseconds) return "microseconds";
  return seconds == kMilliseconds ? "milliseconds" : "seconds";
}

TimeUnit unitOfStamps(std::vector<double> stamps) {
  constexpr double kMostMilliseconds = 1e14, kMostMicroseconds = 1e17, kMostSeconds = 1e11;
  constexpr double kLongStep = 2e3, kVeryLongStep = 2e6;
  stamps.erase(std::remove_if(stamps.begin(), stamps.end(), [](double s) { return !std::isfinite(s); }),
               stamps.end());
  if (stamps.empty()) return {};
  const auto [first, last] = std::minmax_element(stamps.begin(), stamps.end());
  const double largest = std::max(std::abs(*first), std::abs(*last));
  if (largest >= kMostMicroseconds) return {kNanoseconds};
  if (largest >= kMostMilliseconds) return {kMicroseconds};
  if (largest >= kMostSeconds) return {kMilliseconds};
  const std::vector<double> steps = stepsOf(stamps);
  const bool of_epoch = *first >= kFirstEpoch && *last <= kLastEpoch;
  if (steps.empty() || of_epoch || !areWhole(stamps)) return {};
  const double usual = internal::median(steps);
  if (usual >= kVeryLongStep) return {kNanoseconds};
  return {usual >= kLongStep ? kMicroseconds : 1};
}

TimeUnit unitOfNumbers(const std::vector<double>& numbers, bool decimal, bool padded) {
  const TimeUnit unit = unitOfStamps(numbers);
  if (unit.seconds != 1 || numbers.empty() || decimal || !areWhole(numbers)) return unit;
  const auto [first, last] = std::minmax_element(numbers.begin(), numbers.end());
  if (*first < 0 || *last >= kFirstEpoch) return unit;
  if (padded) return {1 / kFrameRate, true};
  const std::vector<double> steps = stepsOf(numbers);
  if (steps.empty()) return unit;
  if (jitter(steps)) return {kMilliseconds};
  return {1 / kFrameRate, true};
}

}  // namespace facetloc::internal
