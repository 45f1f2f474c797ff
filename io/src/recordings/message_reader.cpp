// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/message_reader.h"

#include <fmt/format.h>

namespace facetloc::internal {

namespace {

/** CDR2, D_CDR2 and PL_CDR2 of OMG's DDS-XTypes 7.6.3.1.2, of both byte orders. */
bool isXcdr2(const std::uint8_t* kind) { return kind[0] == 0 && kind[1] >= 6 && kind[1] <= 11; }

}  // namespace

MessageReader::MessageReader(ByteView bytes, WireFormat format)
    : data_(bytes.data), size_(bytes.size), format_(format) {
  if (format == WireFormat::other) throw BadMessage("is of an encoding that is not read");
  if (format != WireFormat::cdr) return;
  constexpr std::size_t kEncapsulation = 4;
  constexpr int kBigEndian = 0, kLittleEndian = 1;
  const std::uint8_t* kind = take(kEncapsulation);
  if (kind[0] != 0 || kind[1] > kLittleEndian)
    throw BadMessage(fmt::format(
        "is not encoded as plain CDR (XCDR1) but by representation 0x{:02x}{:02x}{}", kind[0], kind[1],
        isXcdr2(kind)
            ? ", XCDR2: play it (ros2 bag play), and record it by a middleware that writes XCDR1, which "
              "is the default of rmw_fastrtps_cpp"
            : ""));
  swapped_ = kind[1] == kBigEndian;
  data_ += kEncapsulation, size_ -= kEncapsulation, next_ = 0;  // alignment counts from here
}

void MessageReader::ends() { throw BadMessage("ends before its last field"); }

std::string MessageReader::text() {
  const ByteView text = bytes();
  const std::string_view words(reinterpret_cast<const char*>(text.data), text.size);
  return std::string(words.substr(0, words.find('\0')));  // CDR counts the terminating zero
}

ByteView MessageReader::bytes() {
  const auto size = number<std::uint32_t>();
  return {take(size), size};
}

std::vector<double> MessageReader::reals() {
  const auto size = number<std::uint32_t>();
  if (size > left() / sizeof(double)) ends();
  std::vector<double> values(size);
  for (double& value : values) value = number<double>();
  return values;
}

}  // namespace facetloc::internal
