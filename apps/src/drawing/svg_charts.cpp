// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/svg_charts.h"

#include "drawing/html_text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace facetloc {
namespace {

constexpr double kWidth = 440, kHeight = 300;                       // [px]
constexpr double kLeft = 52, kRight = 12, kTop = 10, kBottom = 42;  // margins of the plot [px]
constexpr double kPlotWidth = kWidth - kLeft - kRight, kPlotHeight = kHeight - kTop - kBottom;

/** Converts values to positions in the plot. */
class Axes {
public:
  explicit Axes(const Panel& panel) : panel_(panel) {}
  double x(double value) const {
    const double share = panel_.logarithmic_x
                             ? (std::log(std::max(value, panel_.x_min)) - std::log(panel_.x_min)) /
                                   (std::log(panel_.x_max) - std::log(panel_.x_min))
                             : (value - panel_.x_min) / (panel_.x_max - panel_.x_min);
    return kLeft + kPlotWidth * std::clamp(share, 0.0, 1.0);
  }
  double y(double value) const {
    const double share = (value - panel_.y_min) / (panel_.y_max - panel_.y_min);
    return kTop + kPlotHeight * (1 - std::clamp(share, 0.0, 1.0));
  }

private:
  const Panel& panel_;
};

/** Round numbers in a range, about five. */
std::vector<double> ticksOf(double lowest, double highest, bool whole) {
  const double wanted = (highest - lowest) / 5, power = std::pow(10, std::floor(std::log10(wanted)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * power >= wanted) step = factor * power;
  if (whole) step = std::max(1.0, std::round(step));
  std::vector<double> ticks;
  for (double i = std::ceil(lowest / step - 1e-9) + 0.0; i * step <= highest + 1e-9 * step; ++i)
    ticks.push_back(i * step + 0.0);  // 0 rather than -0
  return ticks;
}

std::vector<double> logarithmicTicks(double lowest, double highest) {
  std::vector<double> ticks;
  for (double power = std::pow(10, std::floor(std::log10(lowest))); power <= highest; power *= 10)
    for (const double factor : {1.0, 2.0, 5.0})
      if (factor * power >= lowest && factor * power <= highest) ticks.push_back(factor * power);
  return ticks;
}

std::string colourOf(const Curve& curve) {
  return fmt::format("#{:02x}{:02x}{:02x}", curve.colour.red, curve.colour.green, curve.colour.blue);
}

std::string gridOf(const Panel& panel, const Axes& axes) {
  std::string svg;
  const auto ticks = panel.logarithmic_x ? logarithmicTicks(panel.x_min, panel.x_max)
                                         : ticksOf(panel.x_min, panel.x_max, panel.whole_x);
  for (const double tick : ticks)
    svg += fmt::format(
        R"(<path class="grid" d="M{0:.1f} {1}V{2}"/><text x="{0:.1f}" y="{3}" text-anchor="middle">{4:.6g}</text>)",
        axes.x(tick), kTop, kTop + kPlotHeight, kTop + kPlotHeight + 16, tick);
  for (const double tick : ticksOf(panel.y_min, panel.y_max, false))
    svg += fmt::format(
        R"(<path class="grid" d="M{1} {0:.1f}H{2}"/><text x="{3}" y="{4:.1f}" text-anchor="end">{5:.6g}</text>)",
        axes.y(tick), kLeft, kLeft + kPlotWidth, kLeft - 6, axes.y(tick) + 4, tick);
  return svg +
         fmt::format(R"(<text x="{:.1f}" y="{}" text-anchor="middle">{}</text>)", kLeft + kPlotWidth / 2,
                     kHeight - 6, htmlEscaped(panel.x_title)) +
         fmt::format(
             R"svg(<text transform="translate(12 {:.1f}) rotate(-90)" text-anchor="middle">{}</text>)svg",
             kTop + kPlotHeight / 2, htmlEscaped(panel.y_title));
}

std::string curveOf(const Curve& curve, const Axes& axes) {
  std::string svg, path;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    const double x = axes.x(curve.x[i]), y = axes.y(curve.y[i]);
    path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", x, y);
    if (curve.markers)
      svg += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="4" fill="{}"/>)", x, y, colourOf(curve));
  }
  if (curve.x.size() > 1)
    svg += fmt::format(R"(<path d="{}" fill="none" stroke="{}" stroke-width="{:.1f}"{}/>)", path,
                       colourOf(curve), curve.width, curve.dashed ? " stroke-dasharray=\"6 4\"" : "");
  return svg;
}

std::string legendOf(const Panel& panel) {
  std::string html;
  for (const Curve& curve : panel.curves)
    if (!curve.label.empty() && !curve.x.empty())
      html += fmt::format("<span><i style=\"background:{}\"></i>{}</span> ", colourOf(curve),
                          htmlEscaped(curve.label));
  return html.empty() ? "" : "<p class=\"legend\">" + html + "</p>";
}

}  // namespace

std::string svgChart(const Panel& panel) {
  const Axes axes(panel);
  std::string svg = gridOf(panel, axes);
  for (const Curve& curve : panel.curves) svg += curveOf(curve, axes);
  return fmt::format("<figure class=\"chart\"><figcaption>{0}</figcaption><svg viewBox=\"0 0 {1} {2}\" "
                     "role=\"img\" aria-label=\"{0}\">{3}"
                     "</svg>{4}</figure>\n",
                     htmlEscaped(panel.title.empty() ? panel.y_title : panel.title), kWidth, kHeight, svg,
                     legendOf(panel));
}

}  // namespace facetloc
