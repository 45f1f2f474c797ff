// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/page.h"
#include "drawing/pictures.h"

#include <algorithm>

namespace facetloc {

Raster<std::uint8_t> contactSheet(const std::vector<Raster<std::uint8_t>>& pictures,
                                  const std::vector<std::string>& titles) {
  constexpr double kWidth = 800, kGap = 20, kTitle = 28;  // [px]
  constexpr int kColumns = 2;
  double cell = 0;
  for (const auto& picture : pictures)
    cell = std::max(cell, kWidth * picture.height / picture.width + kTitle + kGap);
  const int n = static_cast<int>(pictures.size()), columns = std::min(n, kColumns);
  const int rows = (n + kColumns - 1) / kColumns;
  Page page(static_cast<int>(columns * (kWidth + kGap) + kGap), static_cast<int>(rows * cell + kGap));
  for (int i = 0; i < n; ++i) {
    const double left = kGap + (i % kColumns) * (kWidth + kGap), top = kGap / 2 + (i / kColumns) * cell;
    page.text({left, top + kTitle / 2}, titles[i], {17, true});
    const Box box = {left, top + kTitle, kWidth, kWidth * pictures[i].height / pictures[i].width};
    page.picture(box, pictures[i]);
    page.frame(box, {Colour(190, 190, 190), 1});
  }
  return page.render();
}

}  // namespace facetloc
