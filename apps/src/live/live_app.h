// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "live/live_source.h"
#include "tools/app.h"
#include "tools/depth_input.h"

#include <facetloc/registration/pose_tracking.h>

#include <string>

namespace facetloc {

/** \brief What a live run is asked to do. */
struct LiveRunOptions {
  LiveSourceOptions source;
  std::string map;          ///< file; empty = segmentation only
  std::string results;      ///< folder; empty = none
  std::string screenshots;  ///< folder; empty = none
  std::string recording;    ///< file; empty = none
  int every = 30;           ///< processed frames per screenshot
  bool headless = false;
  bool wait = false;  ///< for a device that is not there, or has gone
  int max_frames = 0;
  double duration = 0;  ///< [s]; 0 = without end
};

/** \brief facetloc_live: segmentation and localization of what a depth camera sees now. */
class LiveApp : public App {
public:
  LiveApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  void checkOptions() const;

  LiveRunOptions run_;
  DepthInput input_;
  double min_probability_ = kMinProbability;
  PoseTrackingParams tracking_;
  GlobalLocalizationParams localization_;
};

}  // namespace facetloc
