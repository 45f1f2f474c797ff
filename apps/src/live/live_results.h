// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "live/live_result.h"

#include <facetloc/features/local_model.h>
#include <facetloc/io/growing_file.h>
#include <facetloc/io/output_lock.h>
#include <facetloc/io/results.h>

#include <filesystem>
#include <memory>
#include <string>

namespace facetloc {

/** \brief The results folder of a live run, written frame by frame: that of facetloc_localize, with one row
 * per frame and a pose where it is certain, and states.csv. Where the view has nothing in common with the
 * map, the pose is told relative to the nearest local model, with a remark. */
class LiveResults {
public:
  /** \brief Begins anew, in the place of older results. \param map may be null
   * \param min_probability of a place, from which on a pose is sure. Throws IoError. */
  LiveResults(const std::filesystem::path& folder, const std::string& params_ini,
              std::shared_ptr<const Map> map, double min_probability = kMinProbability);
  /** \brief All of a frame is in the files when it returns. Throws IoError. */
  void append(const LiveResult& result);

private:
  ResultRow rowOf(const std::string& frame, const Hypothesis& best, const Map& map) const;
  ResultRow rowOf(const std::string& frame, const PoseWithCovariance& pose, const Map& map, int part,
                  double probability) const;
  ResultRow rowOf(const LiveResult& result) const;

  std::shared_ptr<const Map> map_;
  double min_probability_;
  OutputLock lock_;
  ResultsWriter results_;
  GrowingFile states_;
};

}  // namespace facetloc
