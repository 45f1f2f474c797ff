// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <filesystem>

namespace facetloc {

/** \brief Writes a map for other programs, into a folder that is made if need be:
 *
 * - models/NAME.pcd: SegmentFrame clouds in the model's frame; none for a model without segments.
 * Characters that are not at home in file names become _.
 * - poses_tum.txt: the models whose pose was given, by their stamps.
 * - graph.g2o: the models and their links (writeGraph()).
 *
 * Throws IoError. */
void exportMap(const Map& map, const std::filesystem::path& folder);

}  // namespace facetloc
