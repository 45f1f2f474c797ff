// SPDX-License-Identifier: BSD-3-Clause
// A letter that names a type, and bytes as a message of it: of ROS 1 if the letter is a capital, else of
// ROS 2.
#include "fuzz_file.h"
#include "recordings/depth_messages.h"

#include <facetloc/io/error.h>

#include <cctype>
#include <cmath>

namespace {

using namespace facetloc;
using namespace facetloc::internal;

void requireSound(const StoredDepth& values) {
  const auto n = static_cast<std::size_t>(values.width) * static_cast<std::size_t>(values.height);
  fuzz::require(n > 0 && values.metres.size() + values.numbers.size() == n, "an image is not of its size");
  for (const float z : values.metres) fuzz::require(std::isfinite(z) && z >= 0, "a depth is not finite");
}

void readAs(int type, MessageReader& message) {
  if (type == 'i') requireSound(readDepth(ImageMessage::read(message), "image"));
  if (type == 'c') requireSound(readDepth(CompressedImageMessage::read(message), "image"));
  if (type == 'k') CameraInfoMessage::read(message);
  if (type == 'o') OdometryMessage::read(message);
  if (type == 't') TransformsMessage::read(message);
  if (type == 'u') ImuMessage::read(message);
  if (type == 'f') FloatMessage::read(message);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  fuzz::accepts<BadMessage, IoError>([&] {
    MessageReader message({data + 1, size - 1}, std::isupper(data[0]) ? WireFormat::ros1 : WireFormat::cdr);
    readAs(std::tolower(data[0]), message);
  });
  return 0;
}
