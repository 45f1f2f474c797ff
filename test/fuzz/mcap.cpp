// SPDX-License-Identifier: BSD-3-Clause
// Bytes as an MCAP.
#include "message_recording.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  fuzz::readMessageRecording(folder.put("walk.mcap", fuzz::asText(data, size)));
  return 0;
}
