// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/time_units.h"

#include "base/median.h"

#include <algorithm>
#include <cmath>

namespace facetloc::internal {
namespace {

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
