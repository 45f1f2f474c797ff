// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_look.h"

#include <facetloc/features/pose.h>

#include <vtkCamera.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

constexpr double kDegreesPerHeight = 180;          // that a drag over the height of a panel turns
constexpr double kSteepest = 80;                   // [deg]
constexpr double kSmallest = 0.1, kLargest = 100;  // zoom

}  // namespace

void PanelLook::applyTo(vtkCamera* camera) const {
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

std::optional<LiveLooks::Panel> LiveLooks::panelAt(const Eigen::Vector2d& at) const {
  for (const Panel panel : {Panel::cloud, Panel::whole, Panel::near}) {
    const Box& b = box(panel);
    if (at.x() >= b.left && at.x() < b.right() && at.y() >= b.top && at.y() < b.bottom()) return panel;
  }
  return {};
}

void LiveLooks::drag(const Eigen::Vector2d& begin, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                     Drag how) {
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

void LiveLooks::zoom(const Eigen::Vector2d& at, double factor) {
  const auto panel = panelAt(at);
  if (!panel) return;
  PanelLook& look = looks_[static_cast<int>(*panel)];
  const double before = look.zoom;
  look.zoom = std::clamp(before * factor, kSmallest, kLargest);
  const Eigen::Vector2d offset = (at - box(*panel).centre()) / box(*panel).height,
                        place(offset.x(), -offset.y());
  look.shift = place + look.zoom / before * (look.shift - place);
}

}  // namespace facetloc
