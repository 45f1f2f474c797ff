// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <filesystem>

/** \file
 * A map for other programs: as a graph of poses in g2o's text format, and all of it. */

namespace facetloc {

/** \brief Writes VERTEX_SE3:QUAT with the model's index as id, and EDGE_SE3:QUAT for each link.
 *
 * A comment says of which vertices the pose follows from links, in the frame of which part (its index), or is
 * unknown, and then the identity. The information of an edge is about g2o's error, the translation and the
 * quaternion's vector part (half the rotation vector) of the measured inverse times the true relative pose,
 * which lives in the frame of `to`; order (t, R). Throws IoError. */
void writeGraph(const std::filesystem::path& path, const Map& map);

/** \brief Gives the local models in the world the poses that the vertices of a g2o file have, as given ones;
 * those of other parts of the map are left where they are, since their poses in the world are unknown. All
 * other lines of the file are ignored. Throws IoError if a vertex is no local model or has an invalid pose,
 * if a local model in the world has no vertex or two, and if nothing of the map is in a world. */
void readGraphPoses(const std::filesystem::path& path, Map& map);

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
