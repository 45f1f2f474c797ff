// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/map_page.h"
#include "drawing/page.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr double kWidest = 1500, kHighest = 1100;  // size of the plan [px]
constexpr double kNarrowest = 640;                 // leaves room for the legend [px]
constexpr double kMargin = 24;                     // around everything [px]
constexpr double kLegendRow = 26;                  // [px]
constexpr double kSample = 30;                     // width of the sample before a word of the legend [px]
constexpr double kLeastExtent = 0.5;               // smaller plans are drawn as if they were this large [m]
constexpr double kStripMargin = 20, kTitle = 26, kBar = 10;  // film strip [px]
constexpr Colour kSure = {44, 160, 44}, kDoubtful = {255, 127, 14}, kNowhere = {200, 200, 200};
constexpr Colour kModel = {213, 94, 0}, kLink = {230, 159, 0};

/** Scale from metres to a box of a page, in whose middle the extent lies. */
class PlanScale {
public:
  PlanScale(const PlanView& view, const Eigen::AlignedBox2d& extent, double pixels_per_metre, const Box& box)
      : view_(view),
        low_(extent.center() - Eigen::Vector2d(box.width, box.height) / (2 * pixels_per_metre)),
        pixels_per_metre_(pixels_per_metre),
        box_(box) {}

  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d offset = pixels_per_metre_ * (p - low_);
    return {box_.left + offset.x(), box_.bottom() - offset.y()};
  }
  Eigen::Vector2d operator()(const Eigen::Vector3d& p) const { return (*this)(view_.point(p)); }
  Eigen::Vector2d operator()(const Eigen::Isometry3d& T) const {
    return (*this)(view_.point(T.translation()));
  }
  /** Where a camera looks, in the plan. */
  Eigen::Vector2d ahead(const Eigen::Isometry3d& T) const { return view_.direction(T.linear().col(2)); }
  /** The point that is drawn at a place of the page. */
  Eigen::Vector2d pointAt(const Eigen::Vector2d& place) const {
    return low_ + Eigen::Vector2d(place.x() - box_.left, box_.bottom() - place.y()) / pixels_per_metre_;
  }
  double pixelsPerMetre() const { return pixels_per_metre_; }
  const Box& box() const { return box_; }

private:
  PlanView view_;
  Eigen::Vector2d low_;  // [m]
  double pixels_per_metre_;
  Box box_;
};

/** Scale of a plan that is to fill a box. */
double pixelsPerMetreFor(const Eigen::AlignedBox2d& extent, double width, double height) {
  constexpr double kMost = 250;
  const Eigen::Vector2d size = extent.sizes().cwiseMax(kLeastExtent);
  return std::min({width / size.x(), height / size.y(), kMost});
}

/** A segment from above, the darker the taller. \param from, to on the page. */
void drawWall(Page& page, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double height) {
  constexpr Colour kWall = {40, 40, 40};
  const auto alpha = static_cast<std::uint8_t>(35 + 145 * std::min(1.0, height / kTallestWall));
  page.line({from, to}, {kWall.withAlpha(alpha), 1.8});
}

/** A needle that points where a camera looks; none if that is straight up or down.
 * \param at on the page \param ahead its direction in the plan */
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

PlanScale scaleFor(const PlanView& view, const Eigen::AlignedBox2d& extent) {
  const double pixels_per_metre = pixelsPerMetreFor(extent, kWidest, kHighest);
  const Eigen::Vector2d size = pixels_per_metre * extent.sizes().cwiseMax(kLeastExtent);
  const Box box = {kMargin, kMargin, std::ceil(std::max(kNarrowest, size.x())), std::ceil(size.y())};
  return {view, extent, pixels_per_metre, box};
}

void drawModel(Page& page, const Eigen::Vector2d& at, const Eigen::Vector2d& ahead, double size) {
  constexpr double kRadius = 3.5;
  page.disk(at, kRadius, kModel);
  drawHeading(page, at, ahead, size, {kModel, 2});
}

/** Occupied cells dark, unknown ones grey. */
void drawGrid(Page& page, const PlanScale& scale, const OccupancyGrid& grid) {
  constexpr std::uint8_t kOccupied = 60, kUnknown = 232, kFree = 255;
  const Box& box = scale.box();
  Raster<std::uint8_t> picture{static_cast<int>(box.width), static_cast<int>(box.height), 3, {}};
  for (int v = 0; v < picture.height; ++v)
    for (int u = 0; u < picture.width; ++u) {
      const Eigen::Vector2d place(box.left + u + 0.5, box.top + v + 0.5);
      const Eigen::Array2i cell = grid.cellOf(scale.pointAt(place)).array().floor().cast<int>();
      const bool is_beside = !grid.contains(cell.x(), cell.y());
      picture.data.insert(picture.data.end(), 3,
                          grid.isOccupied(cell.x(), cell.y())            ? kOccupied
                          : is_beside || grid.isFree(cell.x(), cell.y()) ? kFree
                                                                         : kUnknown);
    }
  page.picture(box, picture);
}

void drawPlan(Page& page, const PlanScale& scale, const FloorPlan& plan, const std::vector<DrawnRun>& runs,
              const std::vector<DrawnMarks>& marks) {
  for (const PlanLine& wall : plan.walls) drawWall(page, scale(wall.from), scale(wall.to), wall.height);
  for (const auto& [from, to] : plan.links) page.line({scale(from), scale(to)}, {kLink, 1.6});
  for (const DrawnRun& run : runs) {
    Page::Points points;
    for (const Eigen::Isometry3d& T : run.T_w_c) points.push_back(scale(T));
    page.line(points, {run.colour, 2});
    if (!points.empty()) page.disk(points.front(), 4.5, run.colour);
  }
  const double size = std::clamp(0.35 * scale.pixelsPerMetre(), 10.0, 18.0);
  for (const Eigen::Isometry3d& T : plan.models) drawModel(page, scale(T), scale.ahead(T), size);
  for (const DrawnMarks& mark : marks)
    for (const Eigen::Isometry3d& T : mark.T_w_c) drawCross(page, scale(T), mark.colour);
}

/** A sample, drawn at the middle of its left edge, and its meaning. */
struct LegendEntry {
  std::function<void(Page&, const Eigen::Vector2d&)> sample;
  std::string words;
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  // offset from the legend's top left corner
};

std::vector<LegendEntry> legendOf(const FloorPlan& plan, const std::vector<DrawnRun>& runs,
                                  const std::vector<DrawnMarks>& marks) {
  using Vector = Eigen::Vector2d;
  const Vector to_end(kSample - 6, 0), to_middle(kSample / 2 - 3, 0);
  std::vector<LegendEntry> entries;
  const auto add = [&entries](const std::string& words, std::size_t n, auto sample) {
    entries.push_back({sample, fmt::format("{} ({})", words, n)});
  };
  if (!plan.walls.empty())
    add("upright segments", plan.walls.size(),
        [=](Page& p, const Vector& at) { drawWall(p, at, at + to_end, kTallestWall); });
  if (!plan.models.empty())
    add("local models", plan.models.size(), [=](Page& p, const Vector& at) {
      drawModel(p, at + 0.3 * to_middle, {1, 0}, 16);
    });
  if (!plan.links.empty())
    add("links", plan.links.size(), [=](Page& p, const Vector& at) {
      p.line({at, at + to_end}, {kLink, 2});
    });
  for (const DrawnRun& run : runs)
    add(run.name, run.T_w_c.size(), [=, colour = run.colour](Page& p, const Vector& at) {
      p.line({at, at + to_end}, {colour, 2});
      p.disk(at, 4.5, colour);
    });
  for (const DrawnMarks& mark : marks)
    add(mark.name, mark.T_w_c.size(),
        [=, colour = mark.colour](Page& p, const Vector& at) { drawCross(p, at + to_middle, colour); });
  return entries;
}

/** Places entries in rows of at most the given width. \return the height of all rows. */
double place(std::vector<LegendEntry>& entries, double width) {
  constexpr double kGap = 26;
  Eigen::Vector2d at(0, kLegendRow / 2);
  for (LegendEntry& entry : entries) {
    const double needed = kSample + textWidth(entry.words, {});
    if (at.x() > 0 && at.x() + needed > width) at = {0, at.y() + kLegendRow};
    entry.at = at;
    at.x() += needed + kGap;
  }
  return at.y() + kLegendRow / 2;
}

void drawScaleBar(Page& page, const PlanScale& scale, double right, double y) {
  const double length = roundLength(160 / scale.pixelsPerMetre());
  const double width = scale.pixelsPerMetre() * length;
  constexpr double kTick = 5;
  const Pen pen{kBlack, 1.5};
  page.line({{right - width, y}, {right, y}}, pen);
  for (const double x : {right - width, right}) page.line({{x, y - kTick}, {x, y + kTick}}, pen);
  page.text({right - width - 8, y}, fmt::format("{:.9g} m", length), {17, false, kBlack, Across::right});
}

void drawPicture(const std::filesystem::path& path, const FloorPlan& plan, const std::vector<DrawnRun>& runs,
                 const std::vector<DrawnMarks>& marks, const OccupancyGrid* grid) {
  Eigen::AlignedBox2d extent = plan.extent();
  const auto extend = [&](const auto& drawn) {
    for (const Eigen::Isometry3d& T : drawn.T_w_c) extent.extend(plan.view.point(T.translation()));
  };
  std::for_each(runs.begin(), runs.end(), extend);
  std::for_each(marks.begin(), marks.end(), extend);
  if (grid)
    for (const int x : {0, grid->width - 1})
      for (const int y : {0, grid->height - 1}) extent.extend(grid->centre(x, y));
  const PlanScale scale = scaleFor(plan.view, extent);

  constexpr double kBarWidth = 260;
  std::vector<LegendEntry> legend = legendOf(plan, runs, marks);
  const double legend_height = place(legend, scale.box().width - kBarWidth);
  const double legend_top = scale.box().bottom() + 0.75 * kMargin;
  Page page(static_cast<int>(scale.box().right() + kMargin),
            static_cast<int>(legend_top + legend_height + kMargin / 2));
  if (grid) drawGrid(page, scale, *grid);
  drawPlan(page, scale, plan, runs, marks);
  for (const LegendEntry& entry : legend) {
    const Eigen::Vector2d at = Eigen::Vector2d(scale.box().left, legend_top) + entry.at;
    entry.sample(page, at);
    page.text(at + Eigen::Vector2d(kSample, 0), entry.words);
  }
  drawScaleBar(page, scale, scale.box().right(), legend_top + kLegendRow / 2);
  writePng(path, page.render());
}

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
    const double scale = pixelsPerMetreFor(extent, kWidest / columns - kStripMargin,
                                           kHighest / rows - kStripMargin - kTitle - kBar);
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
    const Eigen::Vector2d at = scale(place->T_w_c);
    const double radius = std::max(kLeast, kLargest * std::sqrt(place->probability));
    const double ring = 2 * std::min(place->sd_trans_m, kMostStd) * scale.pixelsPerMetre();
    if (ring > radius && isLikely(*place)) drawRing(page, at, ring, colour);
    page.disk(at, radius, colour);
    if (isLikely(*place)) drawHeading(page, at, scale.ahead(place->T_w_c), radius + 7, {colour, 2});
  }
  if (answer.truth) drawCross(page, scale(*answer.truth), kBlack);
}

}  // namespace

void drawFloorMap(const std::filesystem::path& path, const Map& map, const std::vector<DrawnRun>& runs,
                  const std::vector<DrawnMarks>& marks, const OccupancyGrid* grid) {
  FloorPlan plan = floorPlan(map, path);
  if (grid) plan.walls.clear();
  drawPicture(path, plan, runs, marks, grid);
}

void drawRuns(const std::filesystem::path& path, const PlanView& view, const std::vector<DrawnRun>& runs) {
  drawPicture(path, {view, {}, {}, {}}, runs, {}, nullptr);
}

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
  Page page(static_cast<int>(std::ceil(kStripMargin + grid.columns * (width + kStripMargin))),
            static_cast<int>(std::ceil(kStripMargin + grid.rows * (height + kStripMargin))));
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto column = static_cast<double>(i % grid.columns), row = static_cast<double>(i / grid.columns);
    const double left = kStripMargin + column * (width + kStripMargin),
                 top = kStripMargin + row * (height + kStripMargin);
    const Box box = {left, top + kTitle, width, std::ceil(size.y())};
    page.text({left, top + kTitle / 2}, titles[i]);
    drawBelief(page, PlanScale(plan.view, extent, grid.pixels_per_metre, box), plan, answers[i]);
    drawBar(page, {left, box.bottom() + 2, width, kBar - 4}, answers[i]);
  }
  writePng(path, page.render());
}

}  // namespace facetloc
