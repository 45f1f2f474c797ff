// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace facetloc {

/** \brief How a PLY file writes a number. */
enum class PlyNumber : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
std::size_t sizeOf(PlyNumber type);

/** \brief A number of each element, or a list of numbers. */
struct PlyProperty {
  std::string name;
  PlyNumber type;
  bool is_list = false;
  PlyNumber length = PlyNumber::uint8;  ///< type of a list's length
};
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

/** \brief The header of a PLY file, checked against the length of the data. */
struct PlyHeader {
  enum class Encoding { text, little_endian, big_endian };
  /** \brief Throws IoError with that path. \param bytes of the whole file */
  PlyHeader(std::string_view bytes, const std::string& path);

  Encoding encoding = Encoding::text;
  std::vector<PlyElement> elements;
  std::size_t end = 0;  ///< first byte behind the header
};

}  // namespace facetloc
