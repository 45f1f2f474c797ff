// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/run_images.h"

#include "inputs/depth_input.h"

#include <facetloc/io/error.h>

namespace facetloc {
namespace {

/** Null if there are poses alone: a report does without pictures then. */
std::shared_ptr<const DepthSequence> imagesIn(const std::filesystem::path& recording) {
  try {
    return std::make_shared<const DepthSequence>(DepthSequence::open(recording));
  } catch (const IoError&) {
    return nullptr;
  }
}

}  // namespace

RunImages::RunImages(const PlaceTruth& truth, const Map& map) : map_(map) {
  for (const PlaceTruth::Sequence& s : truth.sequences()) {
    const auto sequence = imagesIn(s.folder);
    if (!sequence) continue;
    for (std::size_t i = 0; i < sequence->frames().size(); ++i)
      for (const std::string& run : {s.folder.filename().string(), std::string()})
        places_.emplace(std::make_pair(run, sequence->frames()[i].name), Place{sequence, i});
  }
}

SeenImage RunImages::seen(const std::string& run, const std::string& name) const {
  const auto found = places_.find({run, name});
  const Place& place = found == places_.end() ? places_.at({"", name}) : found->second;
  const DepthInput defaults;
  const auto& file = place.sequence->camera();
  ViewBuilder builder(map_.calibrated(file ? file->camera : Camera()), defaults.view);
  return see(name, place.sequence->load(place.index, defaults.width), builder);
}

}  // namespace facetloc
