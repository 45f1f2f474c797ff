// SPDX-License-Identifier: BSD-3-Clause
#include "images/depth_codec.h"

#include <stdexcept>

namespace facetloc {
namespace {

struct Corrupt : std::exception {};

class Decoder {
public:
  Decoder(const std::vector<std::uint8_t>& bytes, std::size_t size) : bytes_(bytes), size_(size) {
    out_.reserve(size);
  }

  std::vector<std::uint16_t> decode(bool with_table) {
    if (with_table) readTable();
    value_ = word();
    put();
    while (next_ < bytes_.size()) code(byte());
    if (out_.size() != size_) throw Corrupt();
    return std::move(out_);
  }

private:
  static constexpr int kZero = 6;          // the nibble of no difference
  static constexpr int kLongZero = 192;    // the byte of no difference
  static constexpr int kLong = 0xFF;       // a longer difference follows
  static constexpr int kRepeat = 0xE0;     // more of the same
  static constexpr int kLongSecond = 0xF;  // as second nibble: a longer difference follows
  static constexpr int kNoSecond = 0xD;    // as second nibble: the number of numbers is odd

  int byte() {
    if (next_ >= bytes_.size()) throw Corrupt();
    return bytes_[next_++];
  }
  int word() {  // low byte first
    const int low = byte();
    return low | byte() << 8;
  }
  void readTable() {
    table_.resize(static_cast<std::size_t>(word()));
    for (std::uint16_t& entry : table_) entry = static_cast<std::uint16_t>(word());
    if (table_.empty()) throw Corrupt();
  }
  void put() {
    value_ &= 0xFFFF;
    const auto index = static_cast<std::size_t>(value_);
    if (out_.size() == size_ || (!table_.empty() && index >= table_.size())) throw Corrupt();
    out_.push_back(table_.empty() ? static_cast<std::uint16_t>(value_) : table_[index]);
  }
  void code(int c) {
    if (c == kLong) return longer();
    if (c >= kRepeat) {
      for (int i = 0; i < 2 * (c - kRepeat); ++i) put();
      return;
    }
    value_ -= (c >> 4) - kZero;
    put();
    const int second = c & 0xF;
    if (second == kLongSecond) return longer();
    if (second == kNoSecond) return;
    value_ -= second - kZero;
    put();
  }
  void longer() {
    const int high = byte();
    if (high & 0x80)
      value_ -= high - kLongZero;
    else
      value_ = high << 8 | byte();
    put();
  }

  const std::vector<std::uint8_t>& bytes_;
  std::size_t next_ = 0;
  std::size_t size_;
  std::vector<std::uint16_t> table_;
  std::vector<std::uint16_t> out_;
  int value_ = 0;
};

}  // namespace

std::vector<std::uint16_t> decodeDepth(const std::vector<std::uint8_t>& bytes, bool with_table,
                                       std::size_t size) {
  try {
    return Decoder(bytes, size).decode(with_table);
  } catch (const Corrupt&) {
    return {};
  }
}

}  // namespace facetloc
