// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a map file.
#include "small_map.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc::fuzz;
  static const Folder folder;
  folder.clear();
  useMap(folder.put("room.flmap", asText(data, size)));
  return 0;
}
