// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace facetloc {

/** \brief A simulated floor as the programs of this folder use many of: its map, and views of the later run.
 *
 * The runs are those of facetloc_simulate. Of the mapping run only the images that become local models by the
 * paper's rule are rendered, of the later one every few; both at the working size. */
struct SimulatedFloor {
  Map map;
  Map query;  ///< the views of the later run, T_w_m = T_w_c, the truth
};

/** \brief One view in N of the later run is taken: 348 images make 20 queries. */
constexpr int kQueryStep = 17;

/** \brief The floor of that kind (office, home, hall) and seed, rendered and segmented.
 *
 * The maps of a floor are kept in the folder (SCENE-SEED-map.flmap, SCENE-SEED-query.flmap) and read back the
 * next time. Throws IoError. */
SimulatedFloor simulatedFloor(const std::filesystem::path& folder, const std::string& scene,
                              std::uint64_t seed);

}  // namespace facetloc
