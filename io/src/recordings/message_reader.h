// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace facetloc::internal {

using Bytes = std::vector<std::uint8_t>;

/** \brief Bytes that somebody else owns. */
struct ByteView {
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
};

/** \brief How messages are serialized. */
enum class WireFormat {
  ros1,   ///< ROS 1: packed, little-endian
  cdr,    ///< ROS 2: XCDR1 of OMG's DDS-XTypes 7.4, behind the 4 bytes that name its byte order
  other,  ///< not read here
};

/** \brief A message that does not fit its type. The text continues "its message ...". */
class BadMessage : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/** \brief Reads the fields of one message in their order, in either format. Total on any bytes: it throws
 * BadMessage rather than read beyond the end, and allocates no more than the message has bytes. */
class MessageReader {
public:
  /** \brief Throws BadMessage for CDR with parameter lists, XCDR2, or without an encapsulation. */
  MessageReader(ByteView bytes, WireFormat format);

  WireFormat format() const { return format_; }
  bool atEnd() const { return next_ == size_; }

  template <typename Number>
  Number number() {
    static_assert(std::is_arithmetic_v<Number>);
    align(sizeof(Number));
    std::uint8_t raw[sizeof(Number)];
    std::memcpy(raw, take(sizeof raw), sizeof raw);
    if (swapped_)
      for (std::size_t i = 0; i < sizeof raw / 2; ++i) std::swap(raw[i], raw[sizeof raw - 1 - i]);
    Number value;
    std::memcpy(&value, raw, sizeof value);
    return value;
  }
  std::string text();
  /** \brief A sequence of bytes, which stay where they are. */
  ByteView bytes();
  /** \brief A sequence of doubles. */
  std::vector<double> reals();
  /** \brief Passes over n numbers of a type. */
  template <typename Number>
  void skip(std::size_t n) {
    if (n == 0) return;
    align(sizeof(Number));
    if (n > left() / sizeof(Number)) ends();
    next_ += n * sizeof(Number);
  }

private:
  [[noreturn]] static void ends();
  std::size_t left() const { return size_ - next_; }
  const std::uint8_t* take(std::size_t n) {
    if (n > left()) ends();
    const std::uint8_t* at = data_ + next_;
    next_ += n;
    return at;
  }
  /** A number of CDR begins at a multiple of its size. */
  void align(std::size_t size) {
    if (format_ == WireFormat::cdr) take((size - next_ % size) % size);
  }

  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t next_ = 0;
  WireFormat format_;
  bool swapped_ = false;  // the message is big-endian
};

}  // namespace facetloc::internal
