// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "live/live_result.h"

#include <facetloc/features/local_model.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/results.h>

#include <filesystem>
#include <string>

namespace facetloc {

/** \brief The answer to a frame as results have it: one row, with a pose where it is certain. Where the view
 * has nothing in common with the map, the pose is relative to the nearest local model, with a remark.
 * \param map may be null */
FrameResult frameResult(const LiveResult& result, const Map* map, double min_probability);

/** \brief The results folder of a live run, written frame by frame: as of facetloc_localize, with one row
 * per frame, and states.csv. */
class LiveResults {
public:
  /** \brief Begins anew, in the place of older results. Throws IoError. */
  LiveResults(const std::filesystem::path& folder, const std::string& params_ini);
  /** \brief All of a frame is in the files when it returns. Throws IoError.
   * \param row frameResult() of the result */
  void append(const LiveResult& result, const FrameResult& row);

private:
  OutputLock lock_;
  ResultsWriter results_;
  GrowingFile states_;
};

}  // namespace facetloc
