// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/colours.h"

#include <cmath>

namespace facetloc {

Colour mixed(const Colour& a, const Colour& b, double share_of_b) {
  const auto mix = [share_of_b](int x, int y) {
    return static_cast<std::uint8_t>(std::lround(x + share_of_b * (y - x)));
  };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

Colour segmentColour(std::size_t k) {
  static constexpr std::array<Colour, 12> kColours = {{{0, 114, 178},
                                                       {230, 159, 0},
                                                       {0, 158, 115},
                                                       {204, 121, 167},
                                                       {86, 180, 233},
                                                       {213, 94, 0},
                                                       {240, 228, 66},
                                                       {51, 34, 136},
                                                       {153, 153, 51},
                                                       {136, 34, 85},
                                                       {68, 170, 153},
                                                       {221, 204, 119}}};
  return kColours[k % kColours.size()];
}

}  // namespace facetloc
