// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace facetloc {

/** \brief A colour of a picture. */
struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  std::uint8_t alpha = 255;  ///< 0 = invisible

  Colour() = default;
  constexpr Colour(std::uint8_t r, std::uint8_t g, std::uint8_t b, std::uint8_t a = 255)
      : red(r), green(g), blue(b), alpha(a) {}
  constexpr Colour(const std::array<std::uint8_t, 3>& rgb) : Colour(rgb[0], rgb[1], rgb[2]) {}

  constexpr Colour withAlpha(std::uint8_t a) const { return {red, green, blue, a}; }
};

/** \brief The mixture of two opaque colours; share of the second one from 0 to 1. */
Colour mixed(const Colour& a, const Colour& b, double share_of_b);

constexpr Colour kBlack = {0, 0, 0}, kWhite = {255, 255, 255};

/** \brief The k-th of the colours that tell segments apart, also for the colour-blind (Okabe and Ito; Tol);
 * they repeat. */
Colour segmentColour(std::size_t k);

}  // namespace facetloc
