// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"

#include <facetloc/io/error.h>
#include <facetloc/io/png.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

/** \file
 * Netpbm's images. Private to io. */

namespace facetloc::netpbm {

/** \brief The words of a header, which become numbers; # starts a comment. All functions throw IoError. */
class Header {
public:
  /** \param source named in errors; like the bytes, it must outlive the header */
  Header(const std::string& source, std::string_view bytes) : source_(source), bytes_(bytes) {}

  std::string_view word();
  template <typename Number>
  Number number() {
    const auto value = text::to<Number>(word());
    if (!value) throw IoError(source_, "has a corrupt header");
    return *value;
  }
  /** \brief Behind one blank. */
  std::string_view pixels() const;

private:
  const std::string& source_;
  std::string_view bytes_;
  std::size_t at_ = 0;
};

/** \brief Throws IoError for an image without pixels, or with more than any has. */
void requireSize(const std::string& source, std::uint64_t width, std::uint64_t height);
/** \brief Throws IoError for fewer bytes than an image needs. */
void requireBytes(const std::string& source, std::size_t there, std::uint64_t needed);

/** \brief A grey image and the value that is white in it. */
struct Greymap {
  Raster<std::uint16_t> image;
  int white = 255;
};

/** \brief Parses a PGM of 8 or 16 bits, binary (P5) or in decimal numbers (P2). Throws IoError. */
Greymap parsePgm(const std::string& source, std::string_view bytes);

/** \brief Writes a binary PGM of 8 bits, atomically. Throws IoError. */
void writePgm(const std::filesystem::path& path, const Raster<std::uint8_t>& image);

}  // namespace facetloc::netpbm
