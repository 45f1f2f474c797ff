// SPDX-License-Identifier: BSD-3-Clause
// One of PCL's compressed images: the text of its camera, a zero, and the image.
#include "fuzz_file.h"

#include <facetloc/io/error.h>
#include <facetloc/io/pclzf.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto input = fuzz::asText(data, size);
  const auto zero = std::min(input.find('\0'), input.size());
  const auto camera = folder.put("image.xml", input.substr(0, zero));
  const auto image =
      folder.put("image.pclzf", zero < input.size() ? input.substr(zero + 1) : std::string_view());
  fuzz::accepts<IoError>([&] { readPclzfCamera(camera, 1, 1); });
  fuzz::accepts<IoError>([&] { readPclzf(image); });
  return 0;
}
