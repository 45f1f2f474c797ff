// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/message_file.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace facetloc::internal {

/** \brief A chunk of messages. */
struct ChunkPlace {
  std::uint64_t begin = 0, packed = 0;  ///< its records in the file [bytes]
  std::uint64_t unpacked = 0;           ///< as it claims [bytes]
  std::string compression;              ///< as unpackedChunk() takes it
};

/** \brief A file with its messages in chunks: an MCAP, or a bag of ROS 1. Nothing that it claims is believed
 * before it is compared with the bytes that are there. */
class ChunkedFile : public MessageFile {
protected:
  explicit ChunkedFile(const std::filesystem::path& path);

  std::uint64_t size() const { return size_; }
  bool beginsWith(std::string_view magic) const;
  /** \brief False where the file ends. Thread-safe. */
  bool readAt(std::uint64_t place, std::uint8_t* to, std::size_t n) const;
  /** \brief The same bytes; throws IoError where the file ends. */
  Bytes bytesAt(std::uint64_t place, std::size_t n) const;

  /** \brief Adds a chunk. \return its index and its records, or null if it is damaged; of one that is not
   * whole, those in front of the tear. Throws IoError for more than kLargestMessage. \param crc of the
   * records; 0: not known \param remedy the program that writes smaller chunks */
  std::pair<std::size_t, std::shared_ptr<const Bytes>> addChunk(const ChunkPlace& chunk, bool whole,
                                                                std::uint32_t crc, const char* remedy);
  /** \brief The records of a chunk. Thread-safe. Throws IoError. */
  std::shared_ptr<const Bytes> unpacked(std::size_t index) const;

  void countUndeclared() { ++undeclared_; }
  /** \brief Sorts the entries, and lists the faults found. */
  void finish();

private:
  files::FilePtr file_;
  std::uint64_t size_ = 0;
  std::vector<ChunkPlace> chunks_;
  std::size_t undeclared_ = 0;  // messages
  std::size_t damaged_ = 0;     // chunks
  mutable std::mutex mutex_;    // guards the member below
  mutable std::vector<std::pair<std::size_t, std::shared_ptr<const Bytes>>> kept_;
};

}  // namespace facetloc::internal
