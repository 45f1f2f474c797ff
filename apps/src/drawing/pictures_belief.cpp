// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/map_page.h"
#include "drawing/plan_marks.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr double kWidest = 1500, kHighest = 1100;  // size of all plans together [px]
constexpr double kMargin = 20, kTitle = 26, kBar = 10;
constexpr Colour kSure = {44, 160, 44}, kDoubtful = {255, 127, 14}, kNowhere = {200, 200, 200};

const Colour& colourOf(const PageAnswer& answer) {
  return answer.state == AnswerState::sure ? kSure : kDoubtful;
}

bool isLikely(const PagePlace& place) { return place.probability > 0.01; }

struct Grid {
  int columns = 1, rows = 1;
  double pixels_per_metre = 0;
};

/** The columns with which the plans become largest. */
Grid gridFor(std::size_t plans, const Eigen::AlignedBox2d& extent) {
  Grid best;
  for (int columns = 1; columns <= static_cast<int>(plans); ++columns) {
    const int rows = (static_cast<int>(plans) + columns - 1) / columns;
    const double scale =
        pixelsPerMetreFor(extent, kWidest / columns - kMargin, kHighest / rows - kMargin - kTitle - kBar);
    if (scale > best.pixels_per_metre) best = {columns, rows, scale};
  }
  return best;
}

/** Extent of the plan, and of the places that are likely enough to be looked at. */
Eigen::AlignedBox2d extentOf(const FloorPlan& plan, const std::vector<PageAnswer>& answers) {
  constexpr double kRoom = 0.3;  // about a place, for its disk [m]
  Eigen::AlignedBox2d extent = plan.extent();
  const auto extend = [&](const Eigen::Isometry3d& T_w_c) {
    const Eigen::Vector2d at = plan.view.point(T_w_c.translation());
    extent.extend((at.array() - kRoom).matrix());
    extent.extend((at.array() + kRoom).matrix());
  };
  for (const PageAnswer& answer : answers) {
    for (const PagePlace& place : answer.places)
      if (isLikely(place)) extend(place.T_w_c);
    if (answer.truth) extend(*answer.truth);
  }
  return extent;
}

/** Shares of the probability, side by side; the rest is the probability that the map lacks the place. */
void drawBar(Page& page, const Box& box, const PageAnswer& answer) {
  const auto rectangle = [&](double from, double to, const Colour& fill) {
    const double left = box.left + from * box.width, right = box.left + to * box.width;
    page.polygon({{left, box.top}, {right, box.top}, {right, box.bottom()}, {left, box.bottom()}}, fill);
  };
  rectangle(0, 1, kNowhere);
  double sum = 0;
  for (const PagePlace& place : answer.places) {
    const double next = std::min(1.0, sum + place.probability);
    rectangle(sum, next, colourOf(answer));
    if (next < 1) rectangle(std::max(sum, next - 1 / box.width), next, kWhite);
    sum = next;
  }
}

void drawRing(Page& page, const Eigen::Vector2d& centre, double radius, const Colour& colour) {
  Page::Points points = unitCircle(36);
  points.push_back(points.front());
  for (Eigen::Vector2d& p : points) p = centre + radius * p;
  page.line(points, {colour, 1.2});
}

void drawBelief(Page& page, const PlanScale& scale, const FloorPlan& plan, const PageAnswer& answer) {
  constexpr double kLargest = 9, kLeast = 1.5;  // radius of a disk [px]
  constexpr double kMostStd = 1;                // beyond that a ring would fill the picture [m]
  const Colour colour = colourOf(answer);
  for (const PlanLine& wall : plan.walls) drawWall(page, scale(wall.from), scale(wall.to), wall.height);
  for (auto place = answer.places.rbegin(); place != answer.places.rend(); ++place) {
    const Eigen::Vector2d at = scale(plan.view.point(place->T_w_c.translation()));
    const double radius = std::max(kLeast, kLargest * std::sqrt(place->probability));
    const double ring = 2 * std::min(place->sd_trans_m, kMostStd) * scale.pixelsPerMetre();
    if (ring > radius && isLikely(*place)) drawRing(page, at, ring, colour);
    page.disk(at, radius, colour);
    if (isLikely(*place))
      drawHeading(page, at, plan.view.direction(place->T_w_c.linear().col(2)), radius + 7, {colour, 2});
  }
  if (answer.truth) drawCross(page, scale(plan.view.point(answer.truth->translation())), kBlack);
}

}  // namespace

void drawBeliefs(const std::filesystem::path& path, const Map& map, const std::vector<PageAnswer>& answers,
                 const std::vector<std::string>& titles) {
  if (answers.empty()) throw std::invalid_argument("a film strip needs an image");
  const FloorPlan plan = floorPlan(map, path);
  const Eigen::AlignedBox2d extent = extentOf(plan, answers);
  const Grid grid = gridFor(answers.size(), extent);
  const Eigen::Vector2d size = grid.pixels_per_metre * extent.sizes().cwiseMax(kLeastExtent);
  double width = std::ceil(size.x());
  for (const std::string& title : titles) width = std::max(width, textWidth(title, {}));
  const double height = kTitle + std::ceil(size.y()) + kBar;
  Page page(static_cast<int>(std::ceil(kMargin + grid.columns * (width + kMargin))),
            static_cast<int>(std::ceil(kMargin + grid.rows * (height + kMargin))));
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto column = static_cast<double>(i % grid.columns), row = static_cast<double>(i / grid.columns);
    const double left = kMargin + column * (width + kMargin), top = kMargin + row * (height + kMargin);
    const Box box = {left, top + kTitle, width, std::ceil(size.y())};
    page.text({left, top + kTitle / 2}, titles[i]);
    drawBelief(page, PlanScale(extent, grid.pixels_per_metre, box), plan, answers[i]);
    drawBar(page, {left, box.bottom() + 2, width, kBar - 4}, answers[i]);
  }
  writePng(path, page.render());
}

}  // namespace facetloc
