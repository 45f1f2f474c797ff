// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/vtk_shapes.h"
#include "live/live_look.h"
#include "live/live_result.h"

#include <facetloc/features/local_model.h>

#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>

#include <vector>

namespace facetloc {

/** \brief The colours of the segments of a view, stable from frame to frame: the colour of the
 * matched segment of the local model; without a pose, one by the direction of the normal. */
struct LiveColours {
  std::vector<Colour> of_view;                  ///< indexed by segment
  std::vector<std::optional<Colour>> of_model;  ///< indexed by segment; empty = not matched
  std::size_t matched = 0;                      ///< segments of the view

  LiveColours(const LiveResult& result, const Map* map);
};

/** \brief The cloud in its colours, segment frames, and the segments of the local model, all in the frame of
 * the camera and seen from behind it. */
class LiveCloud {
public:
  LiveCloud();
  /** \brief The cloud, and an overlay always in front of it. Both share their camera. */
  vtkRenderer* ground() { return ground_; }
  vtkRenderer* overlay() { return overlay_; }

  /** \param pixel of the window, from its lower left corner, whose segment is outlined in black
   * \return that segment of the view, if there is one */
  std::optional<std::size_t> show(const LiveResult& result, const LiveColours& colours, const Map* map,
                                  const PanelLook& look, const std::optional<Eigen::Vector2d>& pixel);

private:
  std::optional<std::size_t> segmentAt(const View& view, const Eigen::Vector2d& pixel);
  void showPoints(const SeenImage& image, const LiveColours& colours);
  void addFrame(const Segment& segment);
  void lookFromBehind(const std::optional<CameraMounting>& mounting);

  vtkNew<vtkRenderer> ground_, overlay_;
  vtkNew<vtkPolyData> cloud_;
  Shapes model_, unmatched_model_, frames_, outlines_;
};

}  // namespace facetloc
