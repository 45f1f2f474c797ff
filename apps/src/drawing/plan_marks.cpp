// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/plan_marks.h"

#include "drawing/plan_view.h"

#include <algorithm>

namespace facetloc {

double pixelsPerMetreFor(const Eigen::AlignedBox2d& extent, double width, double height) {
  constexpr double kMost = 250;
  const Eigen::Vector2d size = extent.sizes().cwiseMax(kLeastExtent);
  return std::min({width / size.x(), height / size.y(), kMost});
}

void drawWall(Page& page, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double height) {
  constexpr Colour kWall = {40, 40, 40};
  const auto alpha = static_cast<std::uint8_t>(35 + 145 * std::min(1.0, height / kTallestWall));
  page.line({from, to}, {kWall.withAlpha(alpha), 1.8});
}

void drawHeading(Page& page, const Eigen::Vector2d& at, const Eigen::Vector2d& ahead, double length,
                 const Pen& pen) {
  if (!(ahead.norm() > 0.1)) return;
  const Eigen::Vector2d on_page(ahead.x(), -ahead.y());  // down is where the plan's y becomes smaller
  page.line({at, at + length * on_page.normalized()}, pen);
}

void drawCross(Page& page, const Eigen::Vector2d& at, const Colour& colour) {
  const Eigen::Vector2d a(5, 5), b(5, -5);
  for (const Pen& pen : {Pen{kWhite, 5}, Pen{colour, 2.5}}) {
    page.line({at - a, at + a}, pen);
    page.line({at - b, at + b}, pen);
  }
}

}  // namespace facetloc
