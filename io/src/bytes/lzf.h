// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/** \file
 * LZF, the compression of binary_compressed PCD files and of PCLZF images. PCL's own is in libpcl_io, which
 * brings VTK along; Debian's liblzf reads memory that it has not set, so that its output varies. */

namespace facetloc {

/** \brief Packed bytes, the same for the same bytes. At most a 32nd longer than these. */
std::string lzfPacked(std::string_view bytes);

/** \brief Unpacks into as many bytes as there is room for. False if the packed bytes are not those of so
 * many bytes. */
bool lzfUnpack(std::string_view packed, std::vector<std::uint8_t>& bytes);

}  // namespace facetloc
