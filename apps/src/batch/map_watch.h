// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "cli/progress.h"
#include "cli/stop_signal.h"

#include <facetloc/mapping/map_image.h>

#include <optional>

namespace facetloc {

/** \brief Shows the progress of making a map, stage by stage, and ends it at Ctrl-C. */
class MapWatch {
public:
  explicit MapWatch(const Console& console) : console_(console) {}
  MapWatch(const MapWatch&) = delete;
  MapWatch& operator=(const MapWatch&) = delete;

  /** \brief To be used as long as this lives. It throws Stopped at the first Ctrl-C or SIGTERM. */
  MapProgressCallback callback() {
    return [this](const MapProgress& progress) { show(progress); };
  }

private:
  void show(const MapProgress& progress);
  void end();

  const Console& console_;
  std::optional<MapProgress::Stage> stage_;
  std::size_t shown_ = 0;
  std::optional<Progress> line_;
  std::optional<StopSignal> stop_;  // only while callbacks follow each other soon
};

}  // namespace facetloc
