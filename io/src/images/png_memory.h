// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/png.h>

#include <cstddef>
#include <cstdint>
#include <string>

/** \file
 * PNGs that are part of another file. All throw IoError. Private to io. */

namespace facetloc {

/** \brief As readGreyPng() of a file. \param name of the PNG in errors */
Raster<std::uint16_t> readGreyPng(const std::uint8_t* data, std::size_t size, const std::string& name,
                                  int min_bits);

/** \brief A PNG of 8 bits with four channels: red, green, blue, alpha. */
Raster<std::uint8_t> readRgbaPng(const std::uint8_t* data, std::size_t size, const std::string& name);
/** \brief Is it one with these four channels, by its head? */
bool isRgbaPng(const std::uint8_t* data, std::size_t size);

}  // namespace facetloc
