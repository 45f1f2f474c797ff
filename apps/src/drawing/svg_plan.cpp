// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/floor_plan.h"
#include "drawing/html_text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace facetloc {
namespace {

constexpr double kWidth = 720, kHighest = 520, kMargin = 12;  // [px]
constexpr std::size_t kMostWalls = 20000;

/** Where nearly everything is: segments far outside, as through windows, do not count. */
Eigen::AlignedBox2d extentOf(const FloorPlan& plan, const std::vector<DrawnRun>& runs,
                             const std::vector<DrawnMarks>& marks) {
  constexpr double kOutside = 0.02;  // share of the ends of segments
  Eigen::AlignedBox2d extent;
  std::vector<double> x, y;
  for (const PlanLine& wall : plan.walls)
    for (const Eigen::Vector2d& p : {wall.from, wall.to}) x.push_back(p.x()), y.push_back(p.y());
  if (!x.empty()) {
    std::sort(x.begin(), x.end()), std::sort(y.begin(), y.end());
    const auto first = static_cast<std::size_t>(kOutside * static_cast<double>(x.size() - 1));
    extent.extend(Eigen::Vector2d(x[first], y[first]));
    extent.extend(Eigen::Vector2d(x[x.size() - 1 - first], y[y.size() - 1 - first]));
  }
  for (const Eigen::Isometry3d& T : plan.models) extent.extend(plan.view.point(T.translation()));
  extend(extent, plan.view, runs, marks);
  return extent;
}

/** All segments as two paths: low ones are paler. */
std::string wallsOf(FloorPlan plan, const PlanScale& scale) {
  const auto length = [](const PlanLine& w) { return (w.to - w.from).squaredNorm(); };
  if (plan.walls.size() > kMostWalls) {
    std::stable_sort(plan.walls.begin(), plan.walls.end(),
                     [&](const PlanLine& a, const PlanLine& b) { return length(a) > length(b); });
    plan.walls.resize(kMostWalls);
  }
  std::string low, tall;
  for (const PlanLine& wall : plan.walls) {
    const Eigen::Vector2d a = scale(wall.from), b = scale(wall.to);
    (wall.height < kTallestWall / 2 ? low : tall) +=
        fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", a.x(), a.y(), b.x(), b.y());
  }
  return fmt::format(R"(<path class="low" d="{}"/><path class="wall" d="{}"/>)", low, tall);
}

std::string runsOf(const FloorPlan& plan, const PlanScale& scale, const std::vector<DrawnRun>& runs) {
  std::string svg;
  for (const DrawnRun& run : runs) {
    std::string path;
    for (const Eigen::Isometry3d& T : run.T_w_c) {
      const Eigen::Vector2d p = scale(plan.view.point(T.translation()));
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", p.x(), p.y());
    }
    svg += fmt::format(R"(<path d="{}" fill="none" stroke="{}" stroke-opacity=".6"/>)", path,
                       run.colour.toString());
  }
  return svg;
}

std::string marksOf(const FloorPlan& plan, const PlanScale& scale, const std::vector<DrawnMarks>& marks) {
  constexpr double kRadius = 4, kNeedle = 9;  // [px]
  std::string svg;
  for (const DrawnMarks& mark : marks)
    for (const Eigen::Isometry3d& T : mark.T_w_c) {
      const Eigen::Vector2d p = scale(plan.view.point(T.translation())),
                            d = plan.view.direction(T.linear().col(2));
      if (d.norm() > 0.1)
        svg += fmt::format(R"(<path d="M{:.1f} {:.1f}l{:.1f} {:.1f}" stroke="{}" stroke-width="2"/>)", p.x(),
                           p.y(), kNeedle * d.x() / d.norm(), -kNeedle * d.y() / d.norm(),
                           mark.colour.toString());
      svg += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{}" fill="{}"/>)", p.x(), p.y(), kRadius,
                         mark.colour.toString());
    }
  return svg;
}

std::string scaleBarOf(const PlanScale& scale) {
  const double length = roundLength(120 / scale.pixelsPerMetre());
  const double right = scale.box().right(), y = scale.box().bottom() + 10;
  return fmt::format(
      R"(<path class="bar" d="M{:.1f} {:.1f}H{:.1f}"/><text x="{:.1f}" y="{:.1f}" text-anchor="end">{:.9g} m</text>)",
      right - length * scale.pixelsPerMetre(), y, right, right, y + 15, length);
}

std::string legendOf(const std::vector<DrawnRun>& runs, const std::vector<DrawnMarks>& marks) {
  std::string html;
  const auto add = [&](const Colour& colour, const std::string& words) {
    html +=
        fmt::format("<span><i style=\"background:{}\"></i>{}</span> ", colour.toString(), htmlEscaped(words));
  };
  for (const DrawnMarks& mark : marks)
    if (!mark.T_w_c.empty()) add(mark.colour, fmt::format("{} ({})", mark.name, mark.T_w_c.size()));
  for (const DrawnRun& run : runs) add(run.colour, run.name);
  return html.empty() ? "" : "<p class=\"legend\">" + html + "</p>";
}

}  // namespace

std::string svgFloorMap(const Map& map, const std::vector<DrawnRun>& runs,
                        const std::vector<DrawnMarks>& marks, const std::string& caption) {
  const FloorPlan plan = floorPlan(map, "the plan");
  const Eigen::AlignedBox2d extent = extentOf(plan, runs, marks);
  const double pixels_per_metre = pixelsPerMetreFor(extent, kWidth, kHighest);
  const double height = std::max(120.0, std::ceil(pixels_per_metre * extent.sizes().y()));
  const PlanScale scale(extent, pixels_per_metre, {kMargin, kMargin, kWidth, height});
  return fmt::format("<figure class=\"plan\"><svg viewBox=\"0 0 {} {}\" role=\"img\" "
                     "aria-label=\"{}\">{}{}{}{}</svg>{}<figcaption>{}</figcaption>"
                     "</figure>\n",
                     kWidth + 2 * kMargin, height + 2 * kMargin + 24, htmlEscaped(caption),
                     wallsOf(plan, scale), runsOf(plan, scale, runs), marksOf(plan, scale, marks),
                     scaleBarOf(scale), legendOf(runs, marks), htmlEscaped(caption));
}

}  // namespace facetloc
