// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <string>

namespace facetloc {

/** \brief A colour of a picture. */
struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  std::uint8_t alpha = 255;  ///< 0 = invisible

  constexpr Colour withAlpha(std::uint8_t a) const { return {red, green, blue, a}; }
  /** \brief "#1f77b4", as pages have it. */
  std::string toString() const;
};

/** \brief The mixture of two opaque colours; share of the second one from 0 to 1. */
Colour mixed(const Colour& a, const Colour& b, double share_of_b);

constexpr Colour kBlack = {0, 0, 0}, kWhite = {255, 255, 255}, kRed = {200, 40, 40};

/** \brief Colours of chart curves and of a map's runs: blue, green, orange, purple, brown, pink, teal. */
constexpr Colour kCurveColours[] = {{31, 119, 180}, {44, 160, 44},   {255, 127, 14}, {148, 103, 189},
                                    {140, 86, 75},  {227, 119, 194}, {23, 190, 207}};

/** \brief A colour by direction, as on pages for browsers: upright surfaces have the hue of where they look,
 * the more level the greyer. \param normal, up unit vectors in one frame; hues begin anywhere about up */
Colour directionColour(const Eigen::Vector3d& normal, const Eigen::Vector3d& up);

/** \brief The k-th of the colours that tell segments apart, also for the colour-blind (Okabe and Ito; Tol);
 * they repeat. */
Colour segmentColour(std::size_t k);

}  // namespace facetloc
