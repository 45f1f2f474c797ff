// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/colours.h"

#include <Eigen/Core>
#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include <vector>

namespace facetloc {

/** \brief Many lines and polygons, each of its colour, drawn in one go, for pictures that change
 * many times a second. Opaque, without shading. */
class Shapes {
public:
  using Points = std::vector<Eigen::Vector3d>;

  /** \param line_width [px] */
  explicit Shapes(double line_width = 1) {
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(data_);
    actor_->SetMapper(mapper);
    actor_->GetProperty()->SetLineWidth(static_cast<float>(line_width));
    actor_->GetProperty()->SetLighting(false);
  }

  vtkActor* actor() { return actor_; }

  void line(const Points& points, const Colour& colour, bool closed = false) {
    if (points.size() < 2) return;
    lines_.push_back({points_.size(), points.size(), closed, colour});
    points_.insert(points_.end(), points.begin(), points.end());
  }

  void polygon(const Points& convex, const Colour& colour) {
    if (convex.size() < 3) return;
    polygons_.push_back({points_.size(), convex.size(), false, colour});
    points_.insert(points_.end(), convex.begin(), convex.end());
  }

  /** \brief Replaces the shapes shown by those added since the last time. */
  void show() {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    for (const Eigen::Vector3d& p : points_) points->InsertNextPoint(p.data());
    vtkNew<vtkUnsignedCharArray> colours;
    colours->SetNumberOfComponents(3);
    const auto cellsOf = [&](const std::vector<Cell>& shapes) {
      vtkNew<vtkCellArray> cells;
      for (const Cell& shape : shapes) {
        cells->InsertNextCell(static_cast<int>(shape.size + shape.closed));
        for (std::size_t i = 0; i < shape.size + shape.closed; ++i)
          cells->InsertCellPoint(static_cast<vtkIdType>(shape.first + i % shape.size));
        for (const std::uint8_t part : {shape.colour.red, shape.colour.green, shape.colour.blue})
          colours->InsertNextValue(part);
      }
      return cells;
    };
    data_->Initialize();
    data_->SetPoints(points);
    data_->SetLines(cellsOf(lines_));  // VTK counts lines before polygons
    data_->SetPolys(cellsOf(polygons_));
    data_->GetCellData()->SetScalars(colours);
    actor_->SetVisibility(!lines_.empty() || !polygons_.empty());
    points_.clear(), lines_.clear(), polygons_.clear();
  }

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
