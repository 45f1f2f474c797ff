// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/colours.h"

#include <Eigen/Core>
#include <vtkActor.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

#include <vector>

namespace facetloc {

/** \brief Many lines and polygons, each of its colour, drawn in one go, for pictures that change
 * many times a second. Opaque, without shading. */
class Shapes {
public:
  using Points = std::vector<Eigen::Vector3d>;

  /** \param line_width [px] */
  explicit Shapes(double line_width = 1);
  vtkActor* actor() { return actor_; }

  void line(const Points& points, const Colour& colour, bool closed = false);
  void polygon(const Points& convex, const Colour& colour);
  /** \brief Replaces the shapes shown by those added since the last time. */
  void show();

private:
  struct Cell {
    std::size_t first, size;
    bool closed;
    Colour colour;
  };

  Points points_;
  std::vector<Cell> lines_, polygons_;
  vtkNew<vtkPolyData> data_;
  vtkNew<vtkActor> actor_;
};

}  // namespace facetloc
