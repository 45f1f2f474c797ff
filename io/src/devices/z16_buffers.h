// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/frame_source.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>

namespace facetloc::internal {

/** \brief Layout of an image in a buffer: rows of width 16-bit values, little-endian, with bytes_per_row from
 * one to the next. */
struct Z16Layout {
  int width = 0, height = 0;
  std::size_t bytes_per_row = 0;

  /** \brief Bytes from the first of the first row to the last of the last one. */
  std::size_t bytes() const {
    return bytes_per_row * static_cast<std::size_t>(height - 1) + 2 * static_cast<std::size_t>(width);
  }
};

/** \brief The depths of a buffer that has layout.bytes() bytes at least. */
std::vector<std::uint16_t> depthsOf(const unsigned char* bytes, const Z16Layout& layout);

/** \brief A buffer that was filled; its bytes are there only while take() runs its callback. */
struct Z16Buffer {
  const unsigned char* bytes = nullptr;
  std::size_t size = 0;
  double stamp = 0;  ///< [s]
};

/** \brief Who fills buffers of Z16: a driver of the kernel, or a file. */
class Z16Buffers {
public:
  virtual ~Z16Buffers() = default;
  virtual Z16Layout layout() const = 0;
  /** \brief Hands on the next buffer. \return false if none was filled in time, or none will be. Throws
   * IoError.
   */
  virtual bool take(FrameSource::Patience patience, const std::function<void(const Z16Buffer&)>& use) = 0;
  virtual bool atEnd() const = 0;
  virtual bool isLive() const = 0;
};

/** \param width, height to ask the driver for; 0 = as it is set */
std::unique_ptr<Z16Buffers> openZ16Device(const std::filesystem::path& path, int width, int height);
std::unique_ptr<Z16Buffers> openZ16File(const std::filesystem::path& path, int width, int height);

}  // namespace facetloc::internal
