// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a list of images.
#include "recordings/image_list.h"

#include "fuzz_file.h"

#include <facetloc/io/error.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto path = folder.put("list.txt", fuzz::asText(data, size));
  fuzz::accepts<IoError>([&] {
    for (const auto& image : internal::imagesOfList(path))
      if (image.T_w_c) fuzz::require(image.T_w_c->matrix().allFinite(), "a pose is not finite");
  });
  return 0;
}
