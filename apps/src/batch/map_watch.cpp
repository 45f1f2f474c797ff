// SPDX-License-Identifier: BSD-3-Clause
#include "batch/map_watch.h"

#include "batch/batch.h"

namespace facetloc {

void MapWatch::show(const MapProgress& progress) {
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

void MapWatch::end() {
  stage_.reset();
  shown_ = 0;
  line_.reset();
  stop_.reset();
}

}  // namespace facetloc
