// SPDX-License-Identifier: BSD-3-Clause
// Bytes as the place index of a map. One that is read answers, and is written as it was.
#include "small_map.h"

#include <optional>
#include <sstream>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const Map map = fuzz::smallMap();
  std::istringstream in(std::string(fuzz::asText(data, size)));
  std::optional<PlaceIndex> index;
  fuzz::accepts<std::runtime_error>([&] { index = PlaceIndex::read(in, map); });
  if (!index) return 0;
  for (std::size_t i = 0; i < map.models.size(); ++i) index->candidates(*map.view(static_cast<int>(i)), 10);
  std::ostringstream out;
  index->write(out);
  std::istringstream again(out.str());
  fuzz::require(PlaceIndex::read(again, map).has_value(), "its own output is not read");
  return 0;
}
