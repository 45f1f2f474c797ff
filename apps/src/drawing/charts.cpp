// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/charts.h"

#include "drawing/vtk_picture.h"

#include <vtkAxis.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkContextScene.h>
#include <vtkContextView.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPen.h>
#include <vtkPlotPoints.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

constexpr int kTitleSize = 20, kAxisTitleSize = 17, kLabelSize = 15;  // [px]
constexpr float kMargin = 14;                                         // around a chart [px]

void addColumn(vtkTable* table, const char* name, const std::vector<double>& values) {
  vtkNew<vtkDoubleArray> column;
  column->SetName(name);
  for (const double value : values) column->InsertNextValue(value);
  table->AddColumn(column);
}

void addCurve(vtkChartXY* chart, const Curve& curve) {
  if (curve.x.empty()) return;
  vtkNew<vtkTable> table;
  addColumn(table, "x", curve.x);
  addColumn(table, "y", curve.y);
  vtkPlot* plot = chart->AddPlot(curve.x.size() > 1 ? vtkChart::LINE : vtkChart::POINTS);
  plot->SetInputData(table, 0, 1);
  plot->SetLabel(curve.label);
  plot->SetColor(curve.colour.red, curve.colour.green, curve.colour.blue, curve.colour.alpha);
  plot->SetWidth(curve.width);
  plot->GetPen()->SetLineType(curve.dashed ? vtkPen::DASH_LINE : vtkPen::SOLID_LINE);
  plot->SetLegendVisibility(!curve.label.empty());
  auto* points = vtkPlotPoints::SafeDownCast(plot);
  points->SetMarkerStyle(curve.markers ? vtkPlotPoints::CIRCLE : vtkPlotPoints::NONE);
  points->SetMarkerSize(11);
}

void setAxis(vtkAxis* axis, const std::string& title, double lowest, double highest, bool logarithmic) {
  axis->SetTitle(title);
  axis->GetTitleProperties()->SetFontSize(kAxisTitleSize);
  axis->GetTitleProperties()->SetBold(false);
  axis->GetLabelProperties()->SetFontSize(kLabelSize);
  axis->SetLogScale(logarithmic);
  axis->SetBehavior(vtkAxis::FIXED);
  axis->SetUnscaledRange(lowest, highest);
  axis->GetGridPen()->SetColor(225, 225, 225, 255);
}

void setWholeTicks(vtkAxis* axis, double lowest, double highest) {
  constexpr double kMostTicks = 12;
  const double step = std::max(1.0, std::ceil((highest - lowest) / kMostTicks));
  vtkNew<vtkDoubleArray> ticks;
  for (double x = std::ceil(lowest); x <= highest; x += step) ticks->InsertNextValue(x);
  axis->SetCustomTickPositions(ticks);
}

vtkNew<vtkChartXY> makeChart(const Panel& panel, int width, int height) {
  vtkNew<vtkChartXY> chart;
  chart->SetAutoSize(false);
  const auto& [left, bottom, w, h] = panel.place;
  const auto fw = static_cast<float>(width), fh = static_cast<float>(height);
  chart->SetSize(
      vtkRectf(left * fw + kMargin, bottom * fh + kMargin, w * fw - 2 * kMargin, h * fh - 2 * kMargin));
  chart->SetTitle(panel.title);
  chart->GetTitleProperties()->SetFontSize(kTitleSize);
  chart->GetTitleProperties()->SetBold(true);
  for (const Curve& curve : panel.curves) addCurve(chart, curve);
  setAxis(chart->GetAxis(vtkAxis::BOTTOM), panel.x_title, panel.x_min, panel.x_max, panel.logarithmic_x);
  setAxis(chart->GetAxis(vtkAxis::LEFT), panel.y_title, panel.y_min, panel.y_max, false);
  if (panel.whole_x) setWholeTicks(chart->GetAxis(vtkAxis::BOTTOM), panel.x_min, panel.x_max);
  chart->SetShowLegend(true);
  chart->GetLegend()->SetInline(true);
  chart->GetLegend()->SetLabelSize(kLabelSize);
  chart->GetLegend()->SetHorizontalAlignment(vtkChartLegend::RIGHT);
  chart->GetLegend()->SetVerticalAlignment(vtkChartLegend::BOTTOM);
  return chart;
}

}  // namespace

void drawCharts(const std::filesystem::path& path, int width, int height, const std::vector<Panel>& panels) {
  vtkNew<vtkContextView> view;
  vtkRenderWindow* window = view->GetRenderWindow();
  setOffscreen(window, width, height);
  view->GetRenderer()->SetBackground(1, 1, 1);
  for (const Panel& panel : panels) view->GetScene()->AddItem(makeChart(panel, width, height));
  writePng(path, rendered(window));
}

}  // namespace facetloc
