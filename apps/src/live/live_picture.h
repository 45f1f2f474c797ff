// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "live/live_look.h"
#include "live/live_result.h"

#include <facetloc/features/local_model.h>
#include <facetloc/io/png.h>

#include <memory>
#include <string>
#include <vector>

namespace facetloc {

/** \brief The picture of a live run, for a window on the screen and for files.
 *
 * On the left the cloud, coloured by segment, seen from behind the camera, with the frames of the most useful
 * segments and the uncertainty of their normals; over it, in the same colours, the segments of the local
 * model that the view was matched to. On the right the map from above with the path, the pose and its
 * uncertainty to scale, as a whole and from near; a pose that is not sure is grey; below, the depth image
 * with outlined segments. At the top the state.
 *
 * Needs an X display (OffscreenDisplay), and one thread for all of VTK. */
class LivePicture {
public:
  /** \param window to draw into; \param map may be null. */
  LivePicture(vtkRenderWindow* window, std::shared_ptr<const Map> map);
  ~LivePicture();

  /** \brief Puts a frame into the window, at its present size, and renders it.
   * \param footer lines at the bottom, such as times and keys; pictures that are to be the same for the same
   * frame have none. */
  void show(const LiveResult& result, const std::vector<std::string>& footer = {});

  /** \brief How its user looks at the panels, from the next frame on; places are the last frame's. */
  LiveLooks& looks();
  /** \brief Chooses the item at a place [px from the top left corner]: a segment of the cloud or a local
   * model, which is marked and described in the caption of its panel; nothing elsewhere. */
  void choose(const Eigen::Vector2d& at);

private:
  class Scene;
  std::unique_ptr<Scene> scene_;
};

/** \brief Draws frames of a live run to PNG files, off-screen. The same frame gives the same bytes. */
class LiveScreenshot {
public:
  explicit LiveScreenshot(std::shared_ptr<const Map> map);

  Raster<std::uint8_t> draw(const LiveResult& result);

private:
  vtkNew<vtkRenderWindow> window_;
  LivePicture picture_;
};

}  // namespace facetloc
