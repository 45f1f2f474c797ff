// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/plan_view.h"
#include "drawing/vtk_shapes.h"
#include "live/live_look.h"
#include "live/live_result.h"

#include <facetloc/features/local_model.h>
#include <facetloc/features/map_parts.h>

#include <Eigen/Eigenvalues>
#include <vtkCamera.h>
#include <vtkNew.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace facetloc {

/** \brief The map from above, as a whole and from near, with the way so far and the pose: of a map in parts
 * the one where the camera is, or was last. A map without poses gives nothing to see. */
class LivePlan {
public:
  explicit LivePlan(std::shared_ptr<const Map> map) : map_(std::move(map)), plan_(Eigen::Vector3d::UnitZ()) {
    showPart(mainPart(*map_));
    for (Panel* panel : {&whole_, &near_}) {
      panel->renderer->SetBackground(1, 1, 1);
      panel->renderer->UseFXAAOn();
      for (Shapes* shapes : {&walls_, &links_, &trajectory_, &panel->marker})
        panel->renderer->AddActor(shapes->actor());
    }
  }

  vtkRenderer* whole() { return whole_.renderer; }
  vtkRenderer* near() { return near_.renderer; }
  bool empty() const { return extent_.isEmpty(); }

  /** \brief The places of both panels in the window, the user's zoom and shift, and the chosen item. */
  struct Panels {
    Eigen::Vector2d whole_size, near_size;  ///< [px]; the near panel may have no area
    PanelLook whole, near;
    std::optional<int> chosen;  ///< local model that is marked
  };
  void show(const LiveResult& result, const Panels& panels) {
    constexpr double kBorder = 1.06;
    if (empty()) return;
    if (result.pose() && result.part() != part_) showPart(result.part());
    Eigen::AlignedBox2d extent = extent_;
    for (const LiveTrajectory::Line& line : result.trajectory.lines()) {
      Shapes::Points points;
      for (const Eigen::Vector3d& p : line) points.push_back(at(plan_.point(p), kTrajectoryLevel));
      for (const Eigen::Vector3d& p : points) extent.extend(Eigen::Vector2d(p.head<2>()));
      trajectory_.line(points, kTrajectory);
    }
    trajectory_.show();
    const double aspect = panels.whole_size.x() / panels.whole_size.y();
    const double height = kBorder * std::max(extent.sizes().y(), extent.sizes().x() / aspect);
    mark(whole_, result, look(whole_, extent.center(), height, panels.whole, panels.whole_size),
         panels.chosen);
    near_height_ = result.pose() ? nearHeightOf(ellipseOf(result).colwise().norm().maxCoeff()) : kNearHeight;
    near_middle_ = middleOf(result);
    mark(near_, result, look(near_, near_middle_, near_height_, panels.near, panels.near_size),
         panels.chosen);
  }

  /** \brief Side of the grid of the close-up [m]: the less, the better the pose is known. */
  double nearGrid() const { return roundLength(near_height_ / 3); }
  /** \brief The local model that is drawn at a pixel of the window, from its lower left corner. */
  std::optional<int> modelAt(LiveLooks::Panel which, const Eigen::Vector2d& pixel) {
    Panel& panel = which == LiveLooks::Panel::near ? near_ : whole_;
    const auto pointAt = [&](const Eigen::Vector2d& p) {
      panel.renderer->SetDisplayPoint(p.x(), p.y(), 0);
      panel.renderer->DisplayToWorld();
      return Eigen::Vector2d(panel.renderer->GetWorldPoint()[0], panel.renderer->GetWorldPoint()[1]);
    };
    const Eigen::Vector2d here = pointAt(pixel);
    double nearest = (pointAt(pixel + Eigen::Vector2d(kReach, 0)) - here).norm();
    std::optional<int> found;
    for (std::size_t i = 0; i < map_->models.size(); ++i) {
      const LocalModel& model = map_->models[i];
      if (!model.T_w_m || model.part != part_) continue;
      const double distance = (plan_.point(model.T_w_m->translation()) - here).norm();
      if (distance >= nearest) continue;
      nearest = distance;
      found = static_cast<int>(i);
    }
    return found;
  }

  /** \brief Heading of the camera in the plan, counter-clockwise from x [deg]. */
  double heading(const Eigen::Isometry3d& T_w_c) const {
    const Eigen::Vector2d ahead = plan_.direction(T_w_c.linear().col(2));
    return std::atan2(ahead.y(), ahead.x()) / kDegree;
  }

private:
  static constexpr Colour kWall = {40, 40, 40}, kModel = {213, 94, 0}, kTrajectory = {31, 119, 180},
                          kGridLine = {228, 228, 228};
  static constexpr double kNearHeight = 3.0;  // largest height of the close-up [m]
  static constexpr double kReach = 12;        // largest distance of a click from its target [px]
  static constexpr double kSigmas = 2;        // size of the ellipse in standard deviations
  enum Level {
    kGrid,
    kGround,
    kLinkLevel,
    kModelLevel,
    kEllipseLevel,
    kTrajectoryLevel,
    kOutlineLevel,
    kMarkLevel,
    kEye = 100
  };  // drawing order

  static Eigen::Vector3d at(const Eigen::Vector2d& p, Level level) { return {p.x(), p.y(), double(level)}; }

  static Shapes::Points disk(const Eigen::Vector2d& centre, double radius, Level level, int corners = 36) {
    return disk(centre, radius * Eigen::Matrix2d::Identity(), level, corners);
  }
  static Shapes::Points disk(const Eigen::Vector2d& centre, const Eigen::Matrix2d& shape, Level level,
                             int corners = 36) {
    Shapes::Points points;
    for (const Eigen::Vector2d& unit : unitCircle(corners))
      points.push_back(at(centre + shape * unit, level));
    return points;
  }

  /** The least round height of which an ellipse of this radius takes a quarter at most [m]. */
  static double nearHeightOf(double radius) {
    for (const double height : {0.2, 0.5, 1.0, 2.0})
      if (radius <= height / 8) return height;
    return kNearHeight;
  }

  /** A pose that is not sure is grey at once, before the state of the run changes. */
  static Colour poseColour(const LiveResult& result) {
    constexpr Colour kUntold = {140, 140, 140};
    return result.isLocalized() ? stateColour(result) : kUntold;
  }

  struct Panel {
    vtkNew<vtkRenderer> renderer;
    Shapes marker{2.5};
  };
  void showPart(int part) {
    const FloorPlan plan = floorPlan(*map_, part);
    part_ = part;
    plan_ = plan.view;
    extent_ = plan.extent();
    for (const PlanLine& wall : plan.walls) {
      const double dark = 0.2 + 0.7 * std::min(1.0, wall.height / kTallestWall);
      walls_.line({at(wall.from, kGround), at(wall.to, kGround)}, mixed(kWhite, kWall, dark));
    }
    models_.clear();
    for (const Eigen::Isometry3d& T : plan.models) models_.push_back(plan_.point(T.translation()));
    for (const auto& [from, to] : plan.links)
      links_.line({at(plan_.point(from), kLinkLevel), at(plan_.point(to), kLinkLevel)},
                  mixed(kModel, kWhite, 0.4));
    walls_.show(), links_.show();
  }

  /** Where the camera is, or was last. */
  Eigen::Vector2d middleOf(const LiveResult& result) const {
    if (result.pose()) return plan_.point(result.pose()->T.translation());
    if (!result.trajectory.lines().empty()) return plan_.point(result.trajectory.lines().back().back());
    return extent_.center();
  }

  /** \return metres per pixel. */
  double look(Panel& panel, const Eigen::Vector2d& centre, double height, const PanelLook& look,
              const Eigen::Vector2d& size) {
    vtkCamera* camera = panel.renderer->GetActiveCamera();
    camera->ParallelProjectionOn();
    camera->SetParallelScale(height / 2);
    camera->SetPosition(centre.x(), centre.y(), kEye);
    camera->SetFocalPoint(centre.x(), centre.y(), 0);
    camera->SetViewUp(0, 1, 0);
    look.applyTo(camera);
    camera->SetClippingRange(1, 2.0 * kEye);
    return 2 * camera->GetParallelScale() / std::max(1.0, size.y());
  }

  /** Axes of the ellipse of two standard deviations of the position, to scale [m]. */
  Eigen::Matrix2d ellipseOf(const LiveResult& result) const {
    const Eigen::Matrix3d P = result.pose()->P.bottomRightCorner<3, 3>();
    Eigen::Matrix<double, 2, 3> axes;
    for (int i = 0; i < 3; ++i) axes.col(i) = plan_.direction(Eigen::Vector3d::Unit(i));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(axes * P * axes.transpose());
    const Eigen::Vector2d radii = kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt();
    return solver.eigenvectors() * radii.asDiagonal();
  }

  void addGrid() {
    const double side = nearGrid();
    const Eigen::Vector2d middle = side * (near_middle_ / side).array().round();
    constexpr int kLines = 12;  // to each side
    for (int i = -kLines; i <= kLines; ++i)
      for (const auto& [along, across] : {std::pair(Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)),
                                          std::pair(Eigen::Vector2d(0, 1), Eigen::Vector2d(1, 0))}) {
        const Eigen::Vector2d at_line = middle + i * side * across, half = kLines * side * along;
        near_.marker.line({at(at_line - half, kGrid), at(at_line + half, kGrid)}, kGridLine);
      }
  }

  /** The local models, an arrowhead where the camera is, from near a needle, all of sizes on the screen; its
   * uncertainty, and a ring around a local model that is chosen. */
  void mark(Panel& panel, const LiveResult& result, double metres_per_pixel, std::optional<int> chosen) {
    constexpr double kModelRadius = 2.5;  // [px]
    for (const Eigen::Vector2d& model : models_)
      panel.marker.polygon(disk(model, kModelRadius * metres_per_pixel, kModelLevel, 8), kModel);
    const bool is_near = &panel == &near_;
    if (is_near) addGrid();
    if (chosen && map_->models[*chosen].T_w_m) {
      const Eigen::Vector2d place = plan_.point(map_->models[*chosen].T_w_m->translation());
      panel.marker.line(disk(place, kReach * metres_per_pixel, kMarkLevel), kBlack, true);
    }
    if (!result.pose()) {
      markPlaces(panel, result, metres_per_pixel);
      return panel.marker.show();
    }
    const Eigen::Isometry3d& T = result.pose()->T;
    const Eigen::Vector2d here = plan_.point(T.translation());
    const Colour colour = poseColour(result);
    const Eigen::Matrix2d shape = ellipseOf(result);
    panel.marker.polygon(disk(here, shape, kEllipseLevel), mixed(colour, kWhite, 0.75));
    panel.marker.line(disk(here, shape, kOutlineLevel), colour, true);
    const Eigen::Vector2d ahead = plan_.direction(T.linear().col(2));
    if (ahead.norm() > 0.1) {
      const Eigen::Vector2d x = metres_per_pixel * ahead.normalized(), y(-x.y(), x.x());
      if (is_near)
        panel.marker.line({at(here, kMarkLevel), at(here + 30 * x, kMarkLevel)}, colour);
      else
        panel.marker.polygon({at(here + 12 * x, kMarkLevel), at(here - 5 * x + 6 * y, kMarkLevel),
                              at(here - 5 * x - 6 * y, kMarkLevel)},
                             colour);
    } else {  // it looks straight up or down
      panel.marker.polygon(disk(here, 7 * metres_per_pixel, kMarkLevel), colour);
    }
    panel.marker.show();
  }

  /** Disks where the camera may be. */
  void markPlaces(Panel& panel, const LiveResult& result, double metres_per_pixel) {
    constexpr double kLargest = 10, kLeast = 2;  // [px]
    if (!result.answer || result.pose()) return;
    for (const Hypothesis& place : result.answer->hypotheses) {
      if (place.part != part_) continue;
      const Eigen::Vector2d here = plan_.point(place.T_w_c->translation());
      const double radius = std::max(kLeast, kLargest * std::sqrt(place.probability)) * metres_per_pixel;
      panel.marker.polygon(disk(here, radius, kMarkLevel), poseColour(result));
      const Eigen::Vector2d ahead = plan_.direction(place.T_w_c->linear().col(2));
      const Eigen::Vector2d tip = here + (radius + kLargest * metres_per_pixel) * ahead;
      panel.marker.line({at(here, kMarkLevel), at(tip, kMarkLevel)}, poseColour(result));
    }
  }

  std::shared_ptr<const Map> map_;
  int part_ = 0;  // that is shown
  PlanView plan_;
  Eigen::AlignedBox2d extent_;
  std::vector<Eigen::Vector2d> models_;
  double near_height_ = 1;  // [m]
  Eigen::Vector2d near_middle_ = Eigen::Vector2d::Zero();
  Shapes walls_{1.5}, links_{1.2}, trajectory_{2};
  Panel whole_, near_;
};

}  // namespace facetloc
