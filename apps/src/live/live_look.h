// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/page.h"

#include <facetloc/features/pose.h>

#include <Eigen/Core>
#include <vtkCamera.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace facetloc {

/** \brief How somebody looks at a panel, beside how it shows itself. */
struct PanelLook {
  double yaw_deg = 0, pitch_deg = 0;                ///< turn of a 3D scene about the centre of the view
  double zoom = 1;                                  ///< 2 = twice as large
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  ///< content, right and up, in heights of the panel

  /** \brief Turns, moves and nears a camera of VTK that looks at the middle of a panel. */
  void applyTo(vtkCamera* camera) const {
    camera->Azimuth(yaw_deg);
    camera->Elevation(pitch_deg);
    camera->OrthogonalizeViewUp();
    const bool flat = camera->GetParallelProjection() != 0;
    double height = 2 * camera->GetParallelScale();
    if (flat) {
      camera->SetParallelScale(camera->GetParallelScale() / zoom);
      height /= zoom;
    } else {
      camera->Dolly(zoom);
      height = 2 * camera->GetDistance() * std::tan(camera->GetViewAngle() * kDegree / 2);
    }
    Eigen::Vector3d eye, focus, up;
    camera->GetPosition(eye.data());
    camera->GetFocalPoint(focus.data());
    camera->GetViewUp(up.data());
    const Eigen::Vector3d right = (focus - eye).cross(up).normalized();
    const Eigen::Vector3d step = -height * (shift.x() * right + shift.y() * up.normalized());
    eye += step, focus += step;
    camera->SetPosition(eye.data());
    camera->SetFocalPoint(focus.data());
  }
};

/** \brief Effects of the mouse on the panels of a live picture. Places are in pixels from the top left corner
 * of the window. */
class LiveLooks {
public:
  enum class Panel { cloud, whole, near };
  enum class Drag { turn, move };

  /** \brief The panels are here now; those without an area are not there. */
  void setBoxes(const Box& cloud, const Box& whole, const Box& near) { boxes_ = {cloud, whole, near}; }
  std::optional<Panel> panelAt(const Eigen::Vector2d& at) const {
    for (const Panel panel : {Panel::cloud, Panel::whole, Panel::near}) {
      const Box& b = box(panel);
      if (at.x() >= b.left && at.x() < b.right() && at.y() >= b.top && at.y() < b.bottom()) return panel;
    }
    return {};
  }

  const Box& box(Panel panel) const { return boxes_[static_cast<int>(panel)]; }
  const PanelLook& operator[](Panel panel) const { return looks_[static_cast<int>(panel)]; }

  /** \brief Turns the cloud, or moves the content of the panel where the drag began; maps only move. */
  void drag(const Eigen::Vector2d& begin, const Eigen::Vector2d& from, const Eigen::Vector2d& to, Drag how) {
    const auto panel = panelAt(begin);
    if (!panel) return;
    PanelLook& look = looks_[static_cast<int>(*panel)];
    const Eigen::Vector2d step = (to - from) / box(*panel).height;
    if (*panel == Panel::cloud && how == Drag::turn) {
      look.yaw_deg -= kDegreesPerHeight * step.x();
      look.pitch_deg = std::clamp(look.pitch_deg + kDegreesPerHeight * step.y(), -kSteepest, kSteepest);
    } else {
      look.shift += Eigen::Vector2d(step.x(), -step.y());
    }
  }

  /** \brief Zooms about a place, which stays where it is. */
  void zoom(const Eigen::Vector2d& at, double factor) {
    const auto panel = panelAt(at);
    if (!panel) return;
    PanelLook& look = looks_[static_cast<int>(*panel)];
    const double before = look.zoom;
    look.zoom = std::clamp(before * factor, kSmallest, kLargest);
    const Eigen::Vector2d offset = (at - box(*panel).centre()) / box(*panel).height,
                          place(offset.x(), -offset.y());
    look.shift = place + look.zoom / before * (look.shift - place);
  }

  void reset() { looks_ = {}; }

private:
  static constexpr double kDegreesPerHeight = 180;          // that a drag over the height of a panel turns
  static constexpr double kSteepest = 80;                   // [deg]
  static constexpr double kSmallest = 0.1, kLargest = 100;  // zoom

  std::array<Box, 3> boxes_{};
  std::array<PanelLook, 3> looks_{};
};

}  // namespace facetloc
