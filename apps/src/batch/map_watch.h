// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "batch/batch.h"

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
  void show(const MapProgress& progress) {
    if (stage_ != progress.stage) {
      end();
      stage_ = progress.stage;
      line_.emplace(console_, progress.total);
      if (progress.stage != MapProgress::Stage::loops) stop_.emplace();
    }
    for (; shown_ < progress.done; ++shown_) line_->step();
    if (progress.done >= progress.total) return end();
    if (stop_ && stop_->raised()) throw Stopped(progress.done, progress.total);
  }
  void end() {
    stage_.reset();
    shown_ = 0;
    line_.reset();
    stop_.reset();
  }

  const Console& console_;
  std::optional<MapProgress::Stage> stage_;
  std::size_t shown_ = 0;
  std::optional<Progress> line_;
  std::optional<StopSignal> stop_;  // only while callbacks follow each other soon
};

}  // namespace facetloc
