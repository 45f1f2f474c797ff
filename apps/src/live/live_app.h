// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "inputs/depth_input.h"
#include "live/live_source.h"

#include <facetloc/localization/localizer.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <ostream>
#include <string>

namespace facetloc {

/** \brief The options of a live run. */
struct LiveRunOptions {
  LiveSourceOptions source;
  std::string map;          ///< file; empty = segmentation only
  std::string build;        ///< file of a map to be made; empty = none
  std::string extend;       ///< the map itself, if it is to be brought up to date; empty = it stays
  std::string remember;     ///< file of the last sure pose; empty = none
  std::string results;      ///< folder; empty = none
  std::string screenshots;  ///< folder; empty = none
  std::string recording;    ///< file; empty = none
  std::string odometry;     ///< file, "-" = standard input; empty = none
  std::string near;         ///< where the camera begins (startPose()); empty = not known
  int every = 30;           ///< processed frames per screenshot
  bool headless = false;
  bool wait = false;  ///< for a device that is not there, or has gone
  int max_frames = 0;
  double duration = 0;             ///< [s]; 0 = without end
  std::ostream* stream = nullptr;  ///< answers go here, as lines of JSON (PoseStream); null = nowhere
};

/** \brief facetloc_live: segmentation of live depth images, localization in a map, or a map made of them.
 */
class LiveApp : public App {
public:
  LiveApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  void checkOptions() const;
  int playOrMap(LiveRunOptions options, const CommandLine& line, const Console& console) const;
  int playAndExtend(const LiveRunOptions& options, const CommandLine& line, const Console& console) const;
  int play(const LiveRunOptions& options, const CommandLine& line, const Console& console) const;

  LiveRunOptions run_;
  DepthInput input_;
  std::string map_covers_;
  double min_probability_ = kMinProbability;
  bool overwrite_ = false;
  bool streams_ = false;
  LocalizerParams localizer_;
  OdometryError odometry_error_;
  MappingParams mapping_;
  MapBuilderParams places_;
  GlobalLocalizationParams localization_;
};

}  // namespace facetloc
