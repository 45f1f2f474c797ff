// SPDX-License-Identifier: BSD-3-Clause
// A message of another rank: the first byte says of which type, the others are its bytes. A value that is
// read has the bytes that it was read from.
#include "batch/bytes.h"
#include "fuzz_file.h"

#include <facetloc/io/map_database.h>

namespace {

template <class T>
void receive(const std::string& bytes) {
  using namespace facetloc;
  fuzz::accepts<std::runtime_error>([&] {
    const T value = fromBytes<T>(bytes);
    fuzz::require(toBytes(value) == bytes, "a value has other bytes than it was read from");
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  if (size == 0) return 0;
  const std::string bytes(fuzz::asText(data + 1, size - 1));
  switch (data[0]) {
  case 'n':
    receive<std::size_t>(bytes);
    break;
  case 'N':
    receive<std::vector<std::size_t>>(bytes);
    break;
  case 't':
    receive<std::vector<std::string>>(bytes);
    break;
  case 'd':
    receive<ModelsOrder>(bytes);
    break;
  case 'm':
    receive<PackedModel>(bytes);
    break;
  case 'r':
    receive<LocalizedImage>(bytes);
    break;
  default:
    break;
  }
  return 0;
}
