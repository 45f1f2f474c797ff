// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/colours.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/features/segment.h>

#include <vtkRenderer.h>

#include <optional>
#include <vector>

namespace facetloc {

/** \brief How a segment is drawn. */
struct SegmentLook {
  std::optional<Colour> fill;  ///< opaque; nothing = only the outline
  Colour outline;
  double outline_width = 1;  ///< [px of the renderer]
};

/** \brief The hulls of segments as polygons in space, seen from a camera that shows all of them. */
class SegmentScene {
public:
  explicit SegmentScene(vtkRenderer* renderer) : renderer_(renderer) {}

  void add(const Segment& segment, const Eigen::Isometry3d& T, const SegmentLook& look);
  /** \brief The pyramid of a camera's view, size [m] deep. */
  void addCamera(const Intrinsics& camera, const Eigen::Isometry3d& T, double size, const Colour& colour,
                 double width);
  /** \brief Looks along a direction, so that all of it just fits. */
  void lookAlong(const Eigen::Vector3d& direction, const Eigen::Vector3d& up);

private:
  using Polygon = std::vector<Eigen::Vector3d>;
  void addFill(const Polygon& corners, const Colour& colour);
  void addLine(const Polygon& points, bool closed, const Colour& colour, double width);

  vtkRenderer* renderer_;
  Polygon content_;  // the corners of all segments
};

/** \brief The corners of a camera's image at a depth [m], in its frame. */
std::vector<Eigen::Vector3d> frustum(const Intrinsics& camera, double depth);

/** \brief Where someone looks who stands behind a camera, above it and a little aside. \param up in the frame
 * of the camera, unit vector. */
Eigen::Vector3d fromBehindAndAbove(const Eigen::Vector3d& up);

}  // namespace facetloc
