// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/plan_view.h"
#include "drawing/vtk_shapes.h"
#include "live/live_look.h"
#include "live/live_result.h"

#include <facetloc/features/local_model.h>

#include <vtkNew.h>
#include <vtkRenderer.h>

#include <memory>

namespace facetloc {

/** \brief The map from above, as a whole and from near, with the way so far and the pose: of a map in parts
 * the one where the camera is, or was last. A map without poses gives nothing to see. */
class LivePlan {
public:
  explicit LivePlan(std::shared_ptr<const Map> map);

  vtkRenderer* whole() { return whole_.renderer; }
  vtkRenderer* near() { return near_.renderer; }
  bool empty() const { return extent_.isEmpty(); }

  /** \brief The places of both panels in the window, the user's zoom and shift, and the chosen item. */
  struct Panels {
    Eigen::Vector2d whole_size, near_size;  ///< [px]; the near panel may have no area
    PanelLook whole, near;
    std::optional<int> chosen;  ///< local model that is marked
  };
  void show(const LiveResult& result, const Panels& panels);
  /** \brief Height of the close-up [m]: the less, the better the pose is known. */
  double nearHeight() const { return near_height_; }
  /** \brief The local model that is drawn at a pixel of the window, from its lower left corner. */
  std::optional<int> modelAt(LiveLooks::Panel panel, const Eigen::Vector2d& pixel);
  /** \brief Heading of the camera in the plan, counter-clockwise from x [deg]. */
  double heading(const Eigen::Isometry3d& T_w_c) const;

private:
  struct Panel {
    vtkNew<vtkRenderer> renderer;
    Shapes marker{2.5};
  };
  void showPart(int part);
  Eigen::Vector2d middleOf(const LiveResult& result) const;
  /** \return metres per pixel. */
  double look(Panel& panel, const Eigen::Vector2d& centre, double height, const PanelLook& look,
              const Eigen::Vector2d& size);
  Eigen::Matrix2d ellipseOf(const LiveResult& result) const;
  void mark(Panel& panel, const LiveResult& result, double metres_per_pixel, std::optional<int> chosen);
  void markPlaces(Panel& panel, const LiveResult& result, double metres_per_pixel);

  std::shared_ptr<const Map> map_;
  int part_ = 0;  // that is shown
  PlanView plan_;
  Eigen::AlignedBox2d extent_;
  double near_height_ = 1;  // [m]
  Shapes walls_{1.5}, links_{1.2}, trajectory_{2};
  Panel whole_, near_;
};

}  // namespace facetloc
