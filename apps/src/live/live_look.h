// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/page.h"

#include <Eigen/Core>

#include <array>
#include <optional>

class vtkCamera;

namespace facetloc {

/** \brief How somebody looks at a panel, beside how it shows itself. */
struct PanelLook {
  double yaw_deg = 0, pitch_deg = 0;                ///< turn of a 3D scene about the centre of the view
  double zoom = 1;                                  ///< 2 = twice as large
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  ///< content, right and up, in heights of the panel

  /** \brief Turns, moves and nears a camera of VTK that looks at the middle of a panel. */
  void applyTo(vtkCamera* camera) const;
};

/** \brief Effects of the mouse on the panels of a live picture. Places are in pixels from the top left corner
 * of the window. */
class LiveLooks {
public:
  enum class Panel { cloud, whole, near };
  enum class Drag { turn, move };

  /** \brief The panels are here now; those without an area are not there. */
  void setBoxes(const Box& cloud, const Box& whole, const Box& near) { boxes_ = {cloud, whole, near}; }
  std::optional<Panel> panelAt(const Eigen::Vector2d& at) const;
  const Box& box(Panel panel) const { return boxes_[static_cast<int>(panel)]; }
  const PanelLook& operator[](Panel panel) const { return looks_[static_cast<int>(panel)]; }

  /** \brief Turns the cloud, or moves the content of the panel where the drag began; maps only move. */
  void drag(const Eigen::Vector2d& begin, const Eigen::Vector2d& from, const Eigen::Vector2d& to, Drag how);
  /** \brief Zooms about a place, which stays where it is. */
  void zoom(const Eigen::Vector2d& at, double factor);
  void reset() { looks_ = {}; }

private:
  std::array<Box, 3> boxes_{};
  std::array<PanelLook, 3> looks_{};
};

}  // namespace facetloc
