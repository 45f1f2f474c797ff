// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/pictures.h"
#include "drawing/plan_marks.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>

namespace facetloc {
namespace {

constexpr double kWidest = 1500, kHighest = 1100;  // size of the plan [px]
constexpr double kNarrowest = 640;                 // leaves room for the legend [px]
constexpr double kMargin = 24;                     // around everything [px]
constexpr double kLegendRow = 26;                  // [px]
constexpr double kSample = 30;                     // width of the sample before a word of the legend [px]
constexpr Colour kModel = {213, 94, 0}, kLink = {230, 159, 0};

PlanScale scaleFor(const Eigen::AlignedBox2d& extent) {
  const double pixels_per_metre = pixelsPerMetreFor(extent, kWidest, kHighest);
  const Eigen::Vector2d size = pixels_per_metre * extent.sizes().cwiseMax(kLeastExtent);
  const Box box = {kMargin, kMargin, std::ceil(std::max(kNarrowest, size.x())), std::ceil(size.y())};
  return {extent, pixels_per_metre, box};
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
  for (const auto& [from, to] : plan.links)
    page.line({scale(plan.view.point(from)), scale(plan.view.point(to))}, {kLink, 1.6});
  for (const DrawnRun& run : runs) {
    Page::Points points;
    for (const Eigen::Isometry3d& T : run.T_w_c) points.push_back(scale(plan.view.point(T.translation())));
    page.line(points, {run.colour, 2});
    if (!points.empty()) page.disk(points.front(), 4.5, run.colour);
  }
  const double size = std::clamp(0.35 * scale.pixelsPerMetre(), 10.0, 18.0);
  for (const Eigen::Isometry3d& T : plan.models)
    drawModel(page, scale(plan.view.point(T.translation())), plan.view.direction(T.linear().col(2)), size);
  for (const DrawnMarks& mark : marks)
    for (const Eigen::Isometry3d& T : mark.T_w_c)
      drawCross(page, scale(plan.view.point(T.translation())), mark.colour);
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
  const PlanScale scale = scaleFor(extent);

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

}  // namespace facetloc
