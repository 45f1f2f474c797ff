// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/page.h"
#include "drawing/pictures.h"
#include "drawing/plan_view.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/error.h>
#include <facetloc/io/text.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace facetloc {
namespace {

constexpr double kWidest = 1500, kHighest = 1100;  // of the plan [px]
constexpr double kNarrowest = 640;                 // leaves room for the legend [px]
constexpr double kMostPixelsPerMetre = 250;
constexpr double kMargin = 24;     // around everything [px]
constexpr double kLegendRow = 26;  // [px]
constexpr double kSample = 30;     // width of what stands before a word of the legend [px]
constexpr double kTallest = 1.5;   // a segment of this height or more is drawn darkest [m]
constexpr Colour kWall = {40, 40, 40}, kModel = {213, 94, 0}, kLink = {230, 159, 0};

/** From metres to the page. */
struct Scale {
  Eigen::Vector2d low;  // [m]
  double pixels_per_metre;
  Box plan;

  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d offset = pixels_per_metre * (p - low);
    return {plan.left + offset.x(), plan.bottom() - offset.y()};
  }
};

struct Content {
  std::vector<PlanLine> walls;
  std::vector<Eigen::Isometry3d> models;
  std::vector<std::array<Eigen::Vector3d, 2>> links;
};

Content contentOf(const Map& map, int part, const PlanView& plan) {
  Content content;
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const LocalModel& model = map.models[i];
    if (!model.T_w_m || model.part != part) continue;
    content.models.push_back(*model.T_w_m);
    for (const Segment& segment : map.view(static_cast<int>(i))->segments)
      if (const auto line = plan.line(segment, *model.T_w_m)) content.walls.push_back(*line);
  }
  for (const Link& link : map.links) {
    const auto &from = map.models[link.from].T_w_m, &to = map.models[link.to].T_w_m;
    if (from && to && map.models[link.from].part == part)
      content.links.push_back({from->translation(), to->translation()});
  }
  return content;
}

Eigen::AlignedBox2d extentOf(const Content& content, const PlanView& plan, const std::vector<DrawnRun>& runs,
                             const std::vector<DrawnMarks>& marks) {
  Eigen::AlignedBox2d extent;
  for (const PlanLine& wall : content.walls) extent.extend(wall.from), extent.extend(wall.to);
  const auto extend = [&](const std::vector<Eigen::Isometry3d>& poses) {
    for (const Eigen::Isometry3d& T : poses) extent.extend(plan.point(T.translation()));
  };
  extend(content.models);
  for (const DrawnRun& run : runs) extend(run.T_w_c);
  for (const DrawnMarks& mark : marks) extend(mark.T_w_c);
  return extent;
}

Scale scaleFor(const Eigen::AlignedBox2d& extent) {
  constexpr double kLeastExtent = 0.5;  // [m]
  const Eigen::Vector2d size = extent.sizes().cwiseMax(kLeastExtent);
  Scale scale;
  scale.pixels_per_metre = std::min({kWidest / size.x(), kHighest / size.y(), kMostPixelsPerMetre});
  const double width = std::max(kNarrowest, scale.pixels_per_metre * size.x());
  scale.plan = {kMargin, kMargin, std::ceil(width), std::ceil(scale.pixels_per_metre * size.y())};
  scale.low =
      extent.center() - Eigen::Vector2d(scale.plan.width, scale.plan.height) / (2 * scale.pixels_per_metre);
  return scale;
}

/** A dot with a needle that points where the camera looks. */
void drawModel(Page& page, const Eigen::Vector2d& at, const Eigen::Vector2d& heading, double size) {
  constexpr double kRadius = 3.5;
  page.disk(at, kRadius, kModel);
  if (heading.norm() > 0.1)
    page.line({at, at + size * heading.normalized()}, {kModel, 2});  // else straight up or down
}

void drawCross(Page& page, const Eigen::Vector2d& at, const Colour& colour) {
  const Eigen::Vector2d a(5, 5), b(5, -5);
  for (const Pen& pen : {Pen{kWhite, 5}, Pen{colour, 2.5}}) {
    page.line({at - a, at + a}, pen);
    page.line({at - b, at + b}, pen);
  }
}

void drawWall(Page& page, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double height) {
  const auto alpha = static_cast<std::uint8_t>(35 + 145 * std::min(1.0, height / kTallest));
  page.line({from, to}, {kWall.withAlpha(alpha), 1.8});
}

/** "down" on the page is where the plan's y becomes smaller. */
Eigen::Vector2d onPage(const Eigen::Vector2d& direction) { return {direction.x(), -direction.y()}; }

void drawPlan(Page& page, const Scale& scale, const PlanView& plan, const Content& content,
              const std::vector<DrawnRun>& runs, const std::vector<DrawnMarks>& marks) {
  for (const PlanLine& wall : content.walls) drawWall(page, scale(wall.from), scale(wall.to), wall.height);
  for (const auto& [from, to] : content.links)
    page.line({scale(plan.point(from)), scale(plan.point(to))}, {kLink, 1.6});
  for (const DrawnRun& run : runs) {
    Page::Points points;
    for (const Eigen::Isometry3d& T : run.T_w_c) points.push_back(scale(plan.point(T.translation())));
    page.line(points, {run.colour, 2});
    if (!points.empty()) page.disk(points.front(), 4.5, run.colour);
  }
  const double size = std::clamp(0.35 * scale.pixels_per_metre, 10.0, 18.0);
  for (const Eigen::Isometry3d& T : content.models)
    drawModel(page, scale(plan.point(T.translation())), onPage(plan.direction(T.linear().col(2))), size);
  for (const DrawnMarks& mark : marks)
    for (const Eigen::Isometry3d& T : mark.T_w_c)
      drawCross(page, scale(plan.point(T.translation())), mark.colour);
}

/** A sample, drawn at the middle of its left edge, and what it stands for. */
struct LegendEntry {
  std::function<void(Page&, const Eigen::Vector2d&)> sample;
  std::string words;
};

std::vector<LegendEntry> legendOf(const Content& content, const std::vector<DrawnRun>& runs,
                                  const std::vector<DrawnMarks>& marks) {
  using Vector = Eigen::Vector2d;
  const Vector to_end(kSample - 6, 0), to_middle(kSample / 2 - 3, 0);
  const auto number = [](std::size_t n) { return " (" + std::to_string(n) + ")"; };
  std::vector<LegendEntry> entries;
  entries.push_back({[=](Page& p, const Vector& at) { drawWall(p, at, at + to_end, kTallest); },
                     "upright segments" + number(content.walls.size())});
  entries.push_back({[=](Page& p, const Vector& at) {
                       drawModel(p, at + 0.3 * to_middle, {1, 0}, 16);
                     },
                     "local models" + number(content.models.size())});
  if (!content.links.empty())
    entries.push_back({[=](Page& p, const Vector& at) {
                         p.line({at, at + to_end}, {kLink, 2});
                       },
                       "links" + number(content.links.size())});
  for (const DrawnRun& run : runs)
    entries.push_back({[=, colour = run.colour](Page& p, const Vector& at) {
                         p.line({at, at + to_end}, {colour, 2});
                         p.disk(at, 4.5, colour);
                       },
                       run.name + number(run.T_w_c.size())});
  for (const DrawnMarks& mark : marks)
    entries.push_back(
        {[=, colour = mark.colour](Page& p, const Vector& at) { drawCross(p, at + to_middle, colour); },
         mark.name + number(mark.T_w_c.size())});
  return entries;
}

struct PlacedEntry {
  LegendEntry entry;
  Eigen::Vector2d at;  // from the legend's top left corner
};

/** In rows of at most the given width. \return the height of all rows in rows_height. */
std::vector<PlacedEntry> placed(const std::vector<LegendEntry>& entries, double width, double& rows_height) {
  constexpr double kGap = 26;
  std::vector<PlacedEntry> out;
  Eigen::Vector2d at(0, kLegendRow / 2);
  for (const LegendEntry& entry : entries) {
    const double needed = kSample + textWidth(entry.words, {});
    if (at.x() > 0 && at.x() + needed > width) at = {0, at.y() + kLegendRow};
    out.push_back({entry, at});
    at.x() += needed + kGap;
  }
  rows_height = at.y() + kLegendRow / 2;
  return out;
}

/** The largest of 1, 2, 5, 10, ... that does not exceed a length [m]. */
double roundLength(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= length) return factor * power;
  return power;
}

void drawScaleBar(Page& page, const Scale& scale, double right, double y) {
  const double length = roundLength(160 / scale.pixels_per_metre);
  const double width = scale.pixels_per_metre * length;
  constexpr double kTick = 5;
  const Pen pen{kBlack, 1.5};
  page.line({{right - width, y}, {right, y}}, pen);
  for (const double x : {right - width, right}) page.line({{x, y - kTick}, {x, y + kTick}}, pen);
  TextStyle style;
  style.across = Across::right;
  page.text({right - width - 8, y}, text::significant(length) + " m", style);
}

}  // namespace

void drawFloorMap(const std::filesystem::path& path, const Map& map, const std::vector<DrawnRun>& runs,
                  const std::vector<DrawnMarks>& marks) {
  if (std::none_of(map.models.begin(), map.models.end(),
                   [](const LocalModel& m) { return m.T_w_m.has_value(); }))
    throw IoError(path.string(), "cannot be drawn: no local model of the map has a pose");
  const int part = mainPart(map);
  const PlanView plan(upInPart(map, part));
  const Content content = contentOf(map, part, plan);
  const Scale scale = scaleFor(extentOf(content, plan, runs, marks));

  constexpr double kBarWidth = 260;
  double legend_height = 0;
  const auto legend = placed(legendOf(content, runs, marks), scale.plan.width - kBarWidth, legend_height);
  const double legend_top = scale.plan.bottom() + 0.75 * kMargin;
  Page page(static_cast<int>(scale.plan.right() + kMargin),
            static_cast<int>(legend_top + legend_height + kMargin / 2));
  drawPlan(page, scale, plan, content, runs, marks);
  for (const PlacedEntry& placed_entry : legend) {
    const Eigen::Vector2d at = Eigen::Vector2d(scale.plan.left, legend_top) + placed_entry.at;
    placed_entry.entry.sample(page, at);
    page.text(at + Eigen::Vector2d(kSample, 0), placed_entry.entry.words);
  }
  drawScaleBar(page, scale, scale.plan.right(), legend_top + kLegendRow / 2);
  writePng(path, page.render());
}

}  // namespace facetloc
