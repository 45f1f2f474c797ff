// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <filesystem>

namespace facetloc {

/** \brief Writes a map for other programs, into a folder that is made if need be:
 *
 * - models/<name>.pcd: SegmentFrame clouds in the model's frame; none for a model without segments.
 * Characters that are not at home in file names become _.
 * - poses_tum.txt: the models with a pose, by their stamps.
 * - graph.g2o: VERTEX_SE3:QUAT with the model's index as id (identity where the pose is unknown),
 * EDGE_SE3:QUAT. The information is that of g2o's error, the translation and the quaternion's vector part
 * (half the rotation vector) of the measured inverse times the true relative pose, which lives in the frame
 * of `to`; order (t, R).
 *
 * Throws IoError. */
void exportMap(const Map& map, const std::filesystem::path& folder);

}  // namespace facetloc
