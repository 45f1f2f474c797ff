// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/outputs.h"

#include "cli/command_line.h"

#include <facetloc/io/png.h>

#include <fmt/format.h>

namespace facetloc {

namespace fs = std::filesystem;

void requireOtherFolder(const fs::path& results, const fs::path& images) {
  std::error_code ignored;
  if (fs::equivalent(images.empty() ? fs::path(".") : images, results, ignored))
    throw UsageError(fmt::format("the results would come among the images in {}; use another output folder",
                                 results.string()));
}

void requireNoneButPicture(const fs::path& path) {
  constexpr int kPictureBits = 8;
  if (!fs::exists(path)) return;
  const auto size = pngSize(path);
  if (!size || size->bits != kPictureBits)
    throw UsageError(fmt::format("the picture would overwrite {}, which is not a picture", path.string()));
}

}  // namespace facetloc
