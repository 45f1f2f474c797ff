// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/charts.h"
#include "drawing/plan_view.h"
#include "evaluation/trajectory_report.h"

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

constexpr int kWidth = 1200, kHeight = 1400;  // [px]
constexpr float kPlanShare = 0.6f;            // share of the height
constexpr int kAround = 110;                  // axes, titles and margins of a chart [px]
constexpr double kMargin = 1.1;               // factor on the extent drawn
constexpr double kSmallestPlan = 0.1;         // [m]
constexpr double kSmallestError = 1e-3;       // [mm], [deg]
constexpr Colour kTruth = {110, 110, 110};

/** The axis of the world that the upper edges of the images look to. */
Eigen::Vector3d upOf(const std::vector<PosePair>& pairs) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) sum -= pair.truth.linear().col(1);
  Eigen::Index axis = 0;
  sum.cwiseAbs().maxCoeff(&axis);
  return std::copysign(1.0, sum[axis]) * Eigen::Vector3d::Unit(axis);
}

void add(Curve& curve, double x, double y) {
  curve.x.push_back(x);
  curve.y.push_back(y);
}

/** Both trajectories at one scale. */
Panel planPanel(const TrajectoryErrors& errors) {
  const PlanView plan(upOf(errors.pairs));
  Curve truth, estimate;
  truth.label = "true";
  truth.colour = kTruth;
  truth.width = 4;
  estimate.label = "estimated";
  estimate.width = 2;
  Eigen::AlignedBox2d box;
  for (const PosePair& pair : errors.pairs) {
    const Eigen::Vector2d a = plan.point(pair.truth.translation()),
                          b = plan.point(pair.estimated.translation());
    add(truth, a.x(), a.y());
    add(estimate, b.x(), b.y());
    box.extend(a).extend(b);
  }
  Panel panel;
  panel.title = "From above";
  panel.x_title = panel.y_title = "[m]";
  panel.place = {0, 1 - kPlanShare, 1, kPlanShare};
  const double pixels_x = kWidth - kAround, pixels_y = static_cast<double>(kPlanShare) * kHeight - kAround;
  const double scale = kMargin * std::max({box.sizes().x() / pixels_x, box.sizes().y() / pixels_y,
                                           kSmallestPlan / pixels_x});  // [m/px]
  panel.x_min = box.center().x() - scale * pixels_x / 2;
  panel.x_max = box.center().x() + scale * pixels_x / 2;
  panel.y_min = box.center().y() - scale * pixels_y / 2;
  panel.y_max = box.center().y() + scale * pixels_y / 2;
  panel.curves = {truth, estimate};
  return panel;
}

Panel errorPanel(const std::string& title, const std::string& y_title, const std::vector<double>& way,
                 const std::vector<double>& values, double unit, const Colour& colour) {
  Curve curve;
  curve.colour = colour;
  curve.width = 2;
  double most = kSmallestError;
  for (std::size_t i = 0; i < way.size(); ++i) {
    add(curve, way[i], unit * values[i]);
    most = std::max(most, unit * values[i]);
  }
  Panel panel;
  panel.title = title;
  panel.x_title = "True way [m]";
  panel.y_title = y_title;
  panel.x_max = std::max(way.back(), kSmallestPlan);
  panel.y_max = kMargin * most;
  panel.curves = {curve};
  return panel;
}

}  // namespace

std::vector<Panel> trajectoryPanels(const TrajectoryErrors& errors) {
  constexpr double kMillimetres = 1000;
  constexpr float kErrorShare = (1 - kPlanShare) / 2;
  Panel position = errorPanel("Error of the position after alignment", "[mm]", errors.way, errors.translation,
                              kMillimetres, kCurveColours[0]);
  Panel orientation = errorPanel("Error of the orientation after alignment", "[deg]", errors.way,
                                 errors.rotation_deg, 1, kCurveColours[2]);
  position.place = {0, kErrorShare, 1, kErrorShare};
  orientation.place = {0, 0, 1, kErrorShare};
  return {planPanel(errors), position, orientation};
}

void drawTrajectories(const std::filesystem::path& path, const TrajectoryErrors& errors) {
  drawCharts(path, kWidth, kHeight, trajectoryPanels(errors));
}

}  // namespace facetloc
