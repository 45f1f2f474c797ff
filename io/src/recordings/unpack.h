// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/message_reader.h"

#include <cstdint>
#include <string>

/** \file
 * Compressed bytes. The size that they claim is not trusted: memory grows with
 * the unpacked data. Private to io. */

namespace facetloc::internal {

/** \brief Does it begin as a frame of Zstandard does? */
bool isZstd(ByteView packed);

/** \brief Unpacks Zstandard frames. Throws IoError if they are corrupt, end early or unpack to more than
 * `most` bytes. \param name of the file, in errors */
Bytes unpackZstd(ByteView packed, std::uint64_t most, const std::string& name);

/** \brief Unpacks up to `most` bytes: of a torn chunk, the bytes in front of the tear.
 * \param compression of an MCAP chunk: empty, zstd or lz4. Throws IoError for others. */
Bytes unpackedChunk(ByteView packed, const std::string& compression, std::uint64_t most,
                    const std::string& name);

}  // namespace facetloc::internal
