// SPDX-License-Identifier: BSD-3-Clause
// Bytes as an MCAP.
#include "fuzz_file.h"
#include "recordings/image_container.h"
#include "recordings/message_file.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto path = folder.put("walk.mcap", fuzz::asText(data, size));
  fuzz::accepts<IoError>([&] {
    const auto file = internal::openMcap(path);
    for (const internal::MessageEntry& entry : file->entries()) file->read(entry);
  });
  fuzz::accepts<IoError>([&] {
    const DepthSequence sequence = DepthSequence::open(path);
    sequence.gravity(1);
    for (std::size_t i = 0; i < sequence.frames().size(); ++i)
      fuzz::accepts<IoError>([&] { sequence.load(i, 4); });
  });
  fuzz::accepts<IoError>([&] { internal::readMessageOdometry(path, "camera"); });
  return 0;
}
