// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/colours.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

namespace facetloc {

std::string Colour::toString() const { return fmt::format("#{:02x}{:02x}{:02x}", red, green, blue); }

Colour mixed(const Colour& a, const Colour& b, double share_of_b) {
  const auto mix = [share_of_b](int x, int y) {
    return static_cast<std::uint8_t>(std::lround(x + share_of_b * (y - x)));
  };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

Colour directionColour(const Eigen::Vector3d& normal, const Eigen::Vector3d& up) {
  const Eigen::Vector3d n = rotationBetween(up, Eigen::Vector3d::UnitZ()) * normal;
  const double upright = std::sqrt(std::max(0.0, 1 - n.z() * n.z()));
  const double light = 0.62 + 0.15 * n.z() * (1 - upright),
               chroma = 0.5 * upright * (1 - std::abs(2 * light - 1));
  constexpr double kPi = 3.14159265358979323846;
  const double sextant = (std::atan2(n.y(), n.x()) / kPi + 1) * 3;  // 0 to 6
  const auto channel = [&](double at) {
    const double distance = std::abs(std::remainder(sextant - at, 6));
    const double share = std::clamp(2 - distance, 0.0, 1.0);
    return static_cast<std::uint8_t>(
        std::lround(255 * std::clamp(light + chroma * (share - 0.5) * 2, 0.0, 1.0)));
  };
  return {channel(0), channel(2), channel(4)};
}

Colour segmentColour(std::size_t k) {
  constexpr Colour kColours[] = {{0, 114, 178},  {230, 159, 0}, {0, 158, 115},  {204, 121, 167},
                                 {86, 180, 233}, {213, 94, 0},  {240, 228, 66}, {51, 34, 136},
                                 {153, 153, 51}, {136, 34, 85}, {68, 170, 153}, {221, 204, 119}};
  return kColours[k % std::size(kColours)];
}

}  // namespace facetloc
