// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation_charts.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace facetloc {
namespace {

constexpr Colour kGrey = {110, 110, 110};
constexpr const char* kOfPlanes = "True planes in view";
constexpr const char* kOfDistance = "Distance to the nearest local model [m]";
constexpr double kManyRanks = 30;  // more ranks than this have a logarithmic axis

/** A histogram as a staircase from the axis to the edge of the chart. */
Curve staircase(const Summary& summary, const CumulativeHistogram& histogram, const Panel& panel,
                const Colour& colour) {
  Curve curve;
  curve.label = fmt::format("{} ({})", summary.name, histogram.x.size());
  curve.colour = colour;
  double share = 0;
  const auto add = [&](double x, double y) {
    curve.x.push_back(x);
    curve.y.push_back(y);
  };
  add(panel.x_min, 0);
  for (std::size_t i = 0; i < histogram.x.size(); ++i) {
    add(histogram.x[i], share);
    share = histogram.y[i];
    add(histogram.x[i], share);
  }
  add(panel.x_max, share);
  return curve;
}

/** The 99 % mark of Fig. 6: across to the curve and down to the axis. */
Curve mark(const Panel& panel, double bound, const std::string& label, const Colour& colour) {
  Curve curve;
  curve.label = label;
  curve.x = {panel.x_min, bound, bound};
  curve.y = {kMarkedShare, kMarkedShare, 0};
  curve.colour = colour;
  curve.width = 1.5f;
  curve.dashed = true;
  return curve;
}

struct Fig6Panel {
  Panel panel;
  CumulativeHistogram Summary::*histogram;
  int decimals;
  std::string unit;
  double paper_bound;  // 0 = not known, or not to be shown
};

Panel drawn(const Fig6Panel& what, const std::vector<Summary>& summaries) {
  Panel panel = what.panel;
  panel.y_title = "Share of images";
  panel.y_max = 1.02;
  for (const Summary& summary : summaries)
    if (summary.correct > 0)
      panel.curves.push_back(staircase(summary, summary.*what.histogram, panel,
                                       kCurveColours[panel.curves.size() % kCurveColours.size()]));
  if (panel.curves.empty()) return panel;
  panel.curves.front().width = 5;  // shows beside the others where they coincide
  const double bound = (summaries.front().*what.histogram).bound(kMarkedShare);
  panel.curves.push_back(
      mark(panel, bound, fmt::format("99 %: {:.{}f}{}", bound, what.decimals, what.unit), kRed));
  if (what.paper_bound > 0)
    panel.curves.push_back(
        mark(panel, what.paper_bound,
             fmt::format("99 % in the paper: {:.{}f}{}", what.paper_bound, what.decimals, what.unit), kGrey));
  return panel;
}

/** A dashed line that is there for comparison. */
Curve guide(const std::string& label, double x0, double y0, double x1, double y1) {
  Curve curve;
  curve.label = label;
  curve.x = {x0, x1};
  curve.y = {y0, y1};
  curve.colour = kGrey;
  curve.width = 1.5f;
  curve.dashed = true;
  return curve;
}

/** All ranges by a thin line; those that say something are marked, each a curve of a single point. */
std::vector<Curve> reliabilityCurves(const Summary& summary) {
  Curve line;
  line.label = fmt::format("rank 1, Brier score {:.3f}", summary.brier);
  line.width = 1.5f;
  std::vector<Curve> curves;
  for (const ReliabilityBin& bin : summary.reliability) {
    if (bin.n == 0) continue;
    line.x.push_back(bin.mean_probability);
    line.y.push_back(bin.correct);
    if (bin.n < kReliableCount) continue;
    Curve point;
    point.label = curves.empty() ? fmt::format("of {} images or more", kReliableCount) : "";
    point.x = {bin.mean_probability};
    point.y = {bin.correct};
    point.markers = true;
    curves.push_back(point);
  }
  curves.insert(curves.begin(), line);
  return curves;
}

Panel reliabilityPanel(const Summary& summary) {
  Panel panel;
  panel.title = "Reliability of the probability, " + summary.name;
  panel.x_title = "Mean probability of rank 1";
  panel.y_title = "Share of images where it is correct";
  panel.y_max = 1.02;
  panel.place = {0, 0.3f, 1, 0.7f};
  panel.curves = {guide("ideal, and 0.1 from it", 0, 0, 1, 1), guide("", 0, 0.1, 0.9, 1),
                  guide("", 0.1, 0, 1, 0.9)};
  for (Curve& curve : reliabilityCurves(summary)) panel.curves.push_back(std::move(curve));
  return panel;
}

/** How many images each bin holds, as bars drawn by a line. */
Panel countsPanel(const Summary& summary) {
  Curve bars;
  double most = 1;
  for (const ReliabilityBin& bin : summary.reliability) {
    const double n = static_cast<double>(bin.n);
    most = std::max(most, n);
    for (const auto& [x, y] :
         {std::pair(bin.lowest, 0.0), {bin.lowest, n}, {bin.highest, n}, {bin.highest, 0.0}}) {
      bars.x.push_back(x);
      bars.y.push_back(y);
    }
  }
  Panel panel;
  panel.x_title = "Probability of rank 1";
  panel.y_title = "Images";
  panel.y_max = 1.05 * most;
  panel.place = {0, 0, 1, 0.3f};
  panel.curves = {bars};
  return panel;
}

double shareOf(std::size_t n, const Summary& s) {
  return static_cast<double>(n) / static_cast<double>(s.total);  // share of a group, which has images
}

/** One figure of each group, at the mean of the quantity in it. */
using Figure = double (*)(const Summary&);
Curve curveOf(const std::vector<ErrorGroup>& groups, bool only_correct, Figure figure, const Colour& colour) {
  Curve curve;  // without a label: the legend would hide points
  curve.colour = colour;
  curve.markers = true;
  for (const ErrorGroup& group : groups) {
    if (only_correct && group.summary.correct == 0) continue;
    curve.x.push_back(group.mean);
    curve.y.push_back(figure(group.summary));
  }
  return curve;
}

Panel errorPanel(const std::string& x_title, const std::string& y_title,
                 const std::vector<ErrorGroup>& groups) {
  Panel panel;
  panel.x_title = x_title;
  panel.y_title = y_title;
  panel.x_max = 1.05 * std::max(groups.back().mean, 1.0);
  return panel;
}

Panel shares(const std::string& x_title, const std::vector<ErrorGroup>& groups) {
  Panel panel = errorPanel(x_title, "Share of images", groups);
  panel.title = "Correct anywhere (blue) and at rank 1 (orange)";
  panel.y_max = 1.05;
  panel.curves = {
      curveOf(
          groups, false, [](const Summary& s) { return shareOf(s.correct, s); }, kCurveColours[0]),
      curveOf(
          groups, false, [](const Summary& s) { return shareOf(s.best_correct, s); }, kCurveColours[2])};
  return panel;
}

Panel meanErrors(const std::string& x_title, const std::string& y_title,
                 const std::vector<ErrorGroup>& groups, Figure figure) {
  Panel panel = errorPanel(x_title, y_title, groups);
  panel.title = "Mean error of the first correct hypothesis";
  panel.curves = {curveOf(groups, true, figure, kCurveColours[1])};
  const std::vector<double>& y = panel.curves[0].y;
  if (!y.empty()) panel.y_max = std::max(1e-3, 1.2 * *std::max_element(y.begin(), y.end()));
  return panel;
}

void addErrorColumn(const std::string& x_title, const std::vector<ErrorGroup>& groups, float left,
                    float width, std::vector<Panel>& panels) {
  constexpr float kThird = 1.f / 3;
  if (groups.empty()) return;
  const std::array<Panel, 3> column = {meanErrors(x_title, "Orientation error [deg]", groups,
                                                  [](const Summary& s) { return s.rotation_stats.mean; }),
                                       meanErrors(x_title, "Translation error [mm]", groups,
                                                  [](const Summary& s) { return s.translation_stats.mean; }),
                                       shares(x_title, groups)};
  for (std::size_t row = 0; row < column.size(); ++row) {
    panels.push_back(column[row]);
    panels.back().place = {left, static_cast<float>(row) * kThird, width, kThird};
  }
}

}  // namespace

std::vector<Panel> fig6Panels(const std::vector<Summary>& summaries, const EvaluationParams& params,
                              bool beside_paper) {
  Panel position, orientation, index;
  position.title = "Error in position";
  position.x_title = "Translation error [mm]";
  position.x_max = 1000 * params.max_translation;
  position.place = {0, 0.5f, 0.5f, 0.5f};
  orientation.title = "Error in orientation";
  orientation.x_title = "Orientation error [deg]";
  orientation.x_max = params.max_rotation_deg;
  orientation.place = {0.5f, 0.5f, 0.5f, 0.5f};
  index.title = "Index of the first correct hypothesis";
  index.x_title = "Rank";
  index.place = {0, 0, 1, 0.5f};
  const double largest = summaries.front().index_stats.max;
  index.logarithmic_x = largest > kManyRanks;
  index.whole_x = !index.logarithmic_x;
  index.x_min = index.logarithmic_x ? 1 : 0;
  index.x_max = std::max(largest, 4.0) + 1;

  std::vector<Panel> panels;
  panels.push_back(
      drawn({position, &Summary::translation_mm, 0, " mm", beside_paper ? 164.0 : 0}, summaries));
  panels.push_back(
      drawn({orientation, &Summary::rotation_deg, 1, " deg", beside_paper ? 1.9 : 0}, summaries));
  panels.push_back(drawn({index, &Summary::index, 0, "", 0}, summaries));
  return panels;
}

void drawFig6(const std::filesystem::path& path, const std::vector<Summary>& summaries,
              const EvaluationParams& params) {
  drawCharts(path, 1200, 960, fig6Panels(summaries, params));
}

std::vector<Panel> reliabilityPanels(const Summary& summary) {
  return {reliabilityPanel(summary), countsPanel(summary)};
}

void drawReliability(const std::filesystem::path& path, const Summary& summary) {
  drawCharts(path, 720, 900, reliabilityPanels(summary));
}

std::vector<Panel> errorPanels(const std::vector<ErrorGroup>& by_planes,
                               const std::vector<ErrorGroup>& by_distance) {
  std::vector<Panel> panels;
  const float width = by_planes.empty() || by_distance.empty() ? 1.f : 0.5f;
  addErrorColumn(kOfPlanes, by_planes, 0, width, panels);
  addErrorColumn(kOfDistance, by_distance, 1 - width, width, panels);
  return panels;
}

bool drawErrors(const std::filesystem::path& path, const std::vector<ErrorGroup>& by_planes,
                const std::vector<ErrorGroup>& by_distance) {
  const int columns = (by_planes.empty() ? 0 : 1) + (by_distance.empty() ? 0 : 1);
  if (columns > 0) drawCharts(path, 600 * columns, 960, errorPanels(by_planes, by_distance));
  return columns > 0;
}

}  // namespace facetloc
