// SPDX-License-Identifier: BSD-3-Clause
#include "tools/model_axes.h"

#include "base/text.h"
#include "cli/app.h"

#include <facetloc/features/pose.h>
#include <facetloc/mapping/model_map.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace facetloc {
namespace {

constexpr std::array<std::pair<const char*, double>, 5> kUnits{
    {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}}};

/** "1,2.5,0"; nothing for other words. */
std::optional<Eigen::Vector3d> threeNumbers(const std::string& words) {
  const auto parts = text::split(words, ',');
  if (parts.size() != 3) return {};
  Eigen::Vector3d numbers;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto number = text::to<double>(text::trimmed(parts[k]));
    if (!number || !std::isfinite(*number)) return {};
    numbers[static_cast<Eigen::Index>(k)] = *number;
  }
  return numbers;
}

/** The unit in which a length of a file is nearest to a usual one [m]; null if it is far from it in all. */
const char* unitFor(double in_file, double usual) {
  constexpr double kFar = 3;  // times
  const char* best = nullptr;
  double nearest = std::log(kFar);
  for (const auto& [name, metres] : kUnits)
    if (const double off = std::abs(std::log(in_file * metres / usual)); off < nearest)
      nearest = off, best = name;
  return best;
}

Finding unitQuestion(Severity severity, const std::string& words, const char* unit, double length) {
  return {"model.units",
          severity,
          words,
          unit ? fmt::format("is its unit {0}? --units {0}", unit)
               : std::string("--units names the unit of its coordinates"),
          {{"length_m", length}}};
}

}  // namespace

double metresPer(const std::string& unit) {
  for (const auto& [name, metres] : kUnits)
    if (unit == name) return metres;
  throw UsageError("units: '" + unit + "' is not one of m, cm, mm, in, ft");
}

std::optional<Eigen::Vector3d> directionOf(const std::string& words) {
  if (words == "auto") return {};
  const bool negative = !words.empty() && words[0] == '-';
  const std::string axis = words.substr(negative ? 1 : 0);
  if (axis.size() == 1 && axis[0] >= 'x' && axis[0] <= 'z')
    return (negative ? -1 : 1) * Eigen::Vector3d::Unit(axis[0] - 'x');
  const auto direction = threeNumbers(words);
  if (!direction || direction->norm() == 0)
    throw UsageError("up: '" + words +
                     "' is neither an axis (x, -x, y, ...) nor a direction (0,-1,0.1) nor auto");
  return direction->normalized();
}

Eigen::Vector3d usualUp(const std::filesystem::path& model) {
  return text::lower(model.extension().string()) == ".obj" ? Eigen::Vector3d::UnitY()
                                                           : Eigen::Vector3d::UnitZ();
}

Eigen::Vector3d placeOf(const std::string& words) {
  const auto place = threeNumbers(words);
  if (!place) throw UsageError("inside: '" + words + "' is not of the form x,y,z in metres");
  return *place;
}

std::string toOption(const Eigen::Vector3d& direction) {
  constexpr double kExact = 1e-4;
  for (int k = 0; k < 3; ++k)
    if (1 - std::abs(direction[k]) < kExact * kExact / 2)
      return fmt::format("{}{}", direction[k] < 0 ? "-" : "", "xyz"[k]);
  const Eigen::Vector3d positive = direction + Eigen::Vector3d::Zero();  // no -0
  return fmt::format("{:.4f},{:.4f},{:.4f}", positive.x(), positive.y(), positive.z());
}

std::string upOptions(const SurfaceOrientation& orientation) {
  if (orientation.axes.empty()) return "--up DIRECTION";
  std::vector<std::string> options;
  for (const Eigen::Vector3d& up : orientation.candidates()) options.push_back("--up=" + toOption(up));
  return fmt::format("{}", fmt::join(options, " or "));
}

std::string upRemark(const SurfaceOrientation& orientation, const Eigen::Vector3d& up) {
  using Verdict = SurfaceOrientation::Verdict;
  const SurfaceOrientation::Judgement judged = orientation.judge(up);
  const double angle = std::acos(std::clamp(up.dot(judged.better), -1.0, 1.0)) / kDegree;
  switch (judged.verdict) {
  case Verdict::inclined:
    return fmt::format("its floor is inclined by {:.1f} deg: --up={} levels it", angle,
                       toOption(judged.better));
  case Verdict::upside_down:
    return fmt::format(
        "it is upside down, by the ceilings that it lacks or by what stands on its floors: --up={}",
        toOption(judged.better));
  case Verdict::other_axis:
    return fmt::format(
        "its floors do not face {}, which is up unless --up says otherwise; its largest planes suggest {}",
        toOption(up), upOptions(orientation));
  case Verdict::plausible:
    break;
  }
  return {};
}

std::optional<Finding> unitFinding(const std::string& unit, const SurfaceOrientation& orientation,
                                   const Eigen::AlignedBox3d& bounds, const Eigen::Vector3d& up) {
  constexpr double kLowest = 1, kHighest = 20, kUsual = 2.7;  // height of rooms [m]
  constexpr double kNoRoom = 50;                           // no room is higher, but those of a few domes [m]
  constexpr double kSmallest = 0.5, kUsualExtent = 10;     // extents of a model [m]
  constexpr double kHighestOpen = 50, kNoBuilding = 1000;  // heights of a model without a whole room [m]
  if (bounds.isEmpty()) return {};
  const Eigen::Vector3d size = bounds.sizes();
  if (size.maxCoeff() < kSmallest)
    return unitQuestion(
        Severity::refusal,
        fmt::format("it is only {:.3g} x {:.3g} x {:.3g} m large", size.x(), size.y(), size.z()),
        unitFor(size.maxCoeff() / metresPer(unit), kUsualExtent), size.maxCoeff());
  const double rooms = orientation.judge(up).clear_height, whole = up.cwiseAbs().dot(size);
  const bool is_usual = rooms > 0 ? rooms >= kLowest && rooms <= kHighest : whole <= kHighestOpen;
  if (is_usual) return {};
  const double height = rooms > 0 ? rooms : whole;
  return unitQuestion(
      height > (rooms > 0 ? kNoRoom : kNoBuilding) ? Severity::refusal : Severity::doubt,
      fmt::format("{} {:.{}f} m high", rooms > 0 ? "its rooms are" : "it is", height, height < 10 ? 2 : 0),
      unitFor(height / metresPer(unit), kUsual), height);
}

Finding sizeFinding(std::size_t places, double spacing, bool is_plan) {
  constexpr double kLargest = 10;  // spacing that can be asked for [m]
  constexpr auto kMost = static_cast<double>(ModelMap::kMostPlaces);
  const auto n = static_cast<double>(places);
  const double wider = std::ceil(2 * spacing * std::sqrt(1.05 * n / kMost)) / 2;  // places of two dimensions
  const std::string cure = is_plan ? std::string("look at the resolution in its YAML file")
                                   : std::string("is its unit right? --units names it");
  return {
      "model.size",
      Severity::refusal,
      fmt::format("a camera can be at about {} places in it, more than {}", places, ModelMap::kMostPlaces),
      cure + (wider <= kLargest ? fmt::format(", or take fewer: --spacing {}", wider) : std::string()),
      {{"places", n}}};
}

}  // namespace facetloc
