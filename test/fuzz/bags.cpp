// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a bag of ROS 1 or a database of rosbag2, as the first one says; or a metadata.yaml and, behind the
// line "---", a database beside it.
#include "message_recording.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  if (size == 0) return 0;
  constexpr std::string_view kBreak = "\n---\n";
  const std::string_view bytes = fuzz::asText(data + 1, size - 1);
  folder.clear();
  if (data[0] == 'b') fuzz::readMessageRecording(folder.put("walk.bag", bytes));
  if (data[0] == 'd') fuzz::readMessageRecording(folder.put("walk.db3", bytes));
  if (data[0] != 'f') return 0;
  const std::size_t end = bytes.find(kBreak);
  folder.put("metadata.yaml", bytes.substr(0, end));
  if (end != std::string_view::npos) folder.put("walk_0.db3", bytes.substr(end + kBreak.size()));
  fuzz::readMessageRecording(folder.path());
  return 0;
}
