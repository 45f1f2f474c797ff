// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/plan_view.h"
#include "drawing/vtk_shapes.h"
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

  /** \brief \param whole_size, near_size: of the two panels [px]. */
  void show(const LiveResult& result, const Eigen::Vector2d& whole_size, const Eigen::Vector2d& near_size);
  /** \brief By how much the ellipse of the pose is enlarged in the panel from near. */
  double magnification() const { return magnification_; }
  /** \brief Heading of the camera in the plan, counter-clockwise from x [deg]. */
  double heading(const Eigen::Isometry3d& T_w_c) const;

private:
  struct Panel {
    vtkNew<vtkRenderer> renderer;
    Shapes marker{2.5};
  };
  void showPart(int part);
  Eigen::Vector2d middleOf(const LiveResult& result) const;
  void look(Panel& panel, const Eigen::Vector2d& centre, double height);
  void mark(Panel& panel, const LiveResult& result, double metres_per_pixel, bool with_ellipse);
  void markPlaces(Panel& panel, const LiveResult& result, double metres_per_pixel);

  std::shared_ptr<const Map> map_;
  int part_;  // that is shown
  PlanView plan_;
  Eigen::AlignedBox2d extent_;
  double magnification_ = 1;
  Shapes walls_{1.5}, links_{1.2}, trail_{2};
  Panel whole_, near_;
};

}  // namespace facetloc
