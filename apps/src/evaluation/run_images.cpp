// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/run_images.h"

#include "base/depth_input.h"

namespace facetloc {

RunImages::RunImages(const PlaceTruth& truth, const Map& map) : map_(map) {
  for (const PlaceTruth::Sequence& s : truth.sequences()) {
    if (!std::filesystem::is_directory(s.folder / "depth")) continue;
    const auto sequence = std::make_shared<const DepthSequence>(DepthSequence::open(s.folder));
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
