// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <filesystem>

namespace facetloc {

/** \brief Writes a map for other programs: models/<name>.pcd (SegmentFrame clouds in the model's frame), poses_tum.txt
 * (models with a pose) and graph.g2o (VERTEX_SE3:QUAT, EDGE_SE3:QUAT; information in g2o's order t, R). */
void exportMap(const Map& map, const std::filesystem::path& folder);

}  // namespace facetloc
