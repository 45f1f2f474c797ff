// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "live/live_session.h"

#include <facetloc/mapping/map_builder.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <functional>
#include <optional>
#include <ostream>
#include <string>

namespace facetloc {

/** \brief The options of a live run, and the parameters of its algorithms. */
struct LiveRunOptions {
  LiveSourceOptions source;
  std::vector<std::string> maps;  ///< files of one map or several; none = segmentation only
  std::string build;              ///< file of a map to be made; empty = none
  std::string extend;             ///< the map itself, if it is to be brought up to date; empty = it stays
  std::string remember;           ///< file of the last sure pose; empty = none
  std::string results;            ///< folder; empty = none
  std::string screenshots;        ///< folder; empty = none
  std::string recording;          ///< file; empty = none
  std::string odometry;           ///< file, "-" = standard input; empty = none
  std::string near;               ///< where the camera begins (startPose()); empty = not known
  int every = 30;                 ///< processed frames per screenshot
  bool headless = false;
  bool wait = false;               ///< for a device that is not there, or has gone
  double duration = 0;             ///< [s]; 0 = without end
  std::ostream* stream = nullptr;  ///< answers go here, as lines of JSON (PoseStream); null = nowhere

  std::function<Camera(const std::optional<CameraFile>&)> camera;  ///< that is known with the source
  LiveSessionOptions session;             ///< but for its camera, its map, and the one that it makes
  std::optional<double> min_probability;  ///< none = as the map was calibrated
  MappingParams mapping;
  MapBuilderParams places;
};

/** \brief A live run from its begin to its end. Prints the outcome on one line, also if it fails. Throws the
 * first exception of any thread, after all was written. */
void runLive(const LiveRunOptions& options, const Console& console);

}  // namespace facetloc
