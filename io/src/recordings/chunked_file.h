// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/message_file.h"

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <libdeflate.h>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unistd.h>
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
  explicit ChunkedFile(const std::filesystem::path& path)
      : MessageFile(path), file_(files::open(path)), size_(std::filesystem::file_size(path)) {}

  std::uint64_t size() const { return size_; }
  bool beginsWith(std::string_view magic) const {
    return size_ >= magic.size() &&
           std::memcmp(bytesAt(0, magic.size()).data(), magic.data(), magic.size()) == 0;
  }

  /** \brief False where the file ends. Thread-safe. */
  bool readAt(std::uint64_t place, std::uint8_t* to, std::size_t n) const {
    while (n > 0) {
      const ssize_t got = pread(fileno(file_.get()), to, n, static_cast<off_t>(place));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return false;
      to += got, place += static_cast<std::uint64_t>(got), n -= static_cast<std::size_t>(got);
    }
    return true;
  }

  /** \brief The same bytes; throws IoError where the file ends. */
  Bytes bytesAt(std::uint64_t place, std::size_t n) const {
    Bytes bytes(n);
    if (!readAt(place, bytes.data(), n)) throw IoError(path().string(), "cannot be read");
    return bytes;
  }

  /** \brief Adds a chunk. \return its index and its records, or null if it is damaged; of one that is not
   * whole, those in front of the tear. Throws IoError for more than kLargestMessage. \param crc of the
   * records; 0: not known \param remedy the program that writes smaller chunks */
  std::pair<std::size_t, std::shared_ptr<const Bytes>> addChunk(const ChunkPlace& chunk, bool whole,
                                                                std::uint32_t crc, const char* remedy) {
    if (chunk.unpacked > kLargestMessage)
      throw IoError(path().string(),
                    fmt::format("claims a chunk of {} bytes at byte {}, and {} at most are read; {} writes "
                                "smaller ones",
                                chunk.unpacked, chunk.begin, kLargestMessage, remedy));
    chunks_.push_back(chunk);
    const std::size_t index = chunks_.size() - 1;
    auto records = unpacked(index);
    const bool sound = records->size() == chunk.unpacked &&
                       (crc == 0 || crc == libdeflate_crc32(0, records->data(), records->size()));
    if (whole && !sound) ++damaged_, records = nullptr;
    return {index, records};
  }

  /** \brief The records of a chunk. Thread-safe. Throws IoError. Neighbouring messages are mostly in one
   * chunk: the last few are kept, unless they are large. */
  std::shared_ptr<const Bytes> unpacked(std::size_t index) const {
    constexpr std::size_t kKept = 4, kKeptBytes = 1 << 25;
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [kept, bytes] : kept_)
        if (kept == index) return bytes;
    }
    const ChunkPlace& chunk = chunks_.at(index);
    if (chunk.packed > kLargestMessage) throw IoError(path().string(), "has a chunk that is too large");
    const Bytes packed = bytesAt(chunk.begin, chunk.packed);
    auto bytes = std::make_shared<const Bytes>(
        unpackedChunk(packed, chunk.compression, chunk.unpacked, path().string()));
    const std::lock_guard lock(mutex_);
    kept_.emplace_back(index, bytes);
    std::size_t total = 0;
    for (const auto& kept : kept_) total += kept.second->size();
    while (kept_.size() > kKept || (kept_.size() > 1 && total > kKeptBytes)) {
      total -= kept_.front().second->size();
      kept_.erase(kept_.begin());
    }
    return bytes;
  }

  void countUndeclared() { ++undeclared_; }
  /** \brief Sorts the entries, and lists the faults found. */
  void finish() {
    if (damaged_ > 0)
      addFault(fmt::format("{} of its {} chunks {} damaged and left out", damaged_, chunks_.size(),
                           damaged_ == 1 ? "is" : "are"));
    if (undeclared_ > 0)
      addFault(fmt::format("{} of its messages {} of a channel that is not declared", undeclared_,
                           undeclared_ == 1 ? "is" : "are"));
    sortEntries();
  }

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
