// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/pictures.h"
#include "evaluation/frame_truth.h"

#include <facetloc/io/depth_sequence.h>

#include <map>
#include <memory>
#include <string>
#include <utility>

namespace facetloc {

/** \brief The depth images of all runs of a place, where they are there. Of runs whose images have the same
 * names, the one that is asked for goes first. Refers to the map. */
class RunImages {
public:
  RunImages(const PlaceTruth& truth, const Map& map);

  bool has(const std::string& name) const { return places_.count({"", name}) > 0; }
  /** \brief An image, seen by its camera as the map knows it. Throws IoError, std::out_of_range for an image
   * that is not there. */
  SeenImage seen(const std::string& run, const std::string& name) const;

private:
  struct Place {
    std::shared_ptr<const DepthSequence> sequence;
    std::size_t index;
  };
  const Map& map_;
  std::map<std::pair<std::string, std::string>, Place> places_;  // keyed by run, or "", and name
};

}  // namespace facetloc
