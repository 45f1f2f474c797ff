// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/finding.h>
#include <facetloc/features/occupancy_grid.h>

#include <filesystem>

namespace facetloc {

/** \brief Reads an occupancy grid as ROS's map_server does: a YAML file with image, resolution and origin,
 * and with negate, occupied_thresh, free_thresh and mode (trinary, scale or raw) if they differ from 0, 0.65,
 * 0.196 and trinary; the image, a PGM (P2, P5) or a greyscale PNG, is where it says, or else in the
 * folder of the YAML file under its name. Cells of the grey 205, by which map_saver marks unknown ones, stay
 * unknown where free_thresh would make them free, unless no other cell is. Throws IoError for files that are
 * missing or damaged, and for values that no grid can have.
 * \param findings receives remarks on the image and on unknown cells, unless null */
OccupancyGrid readOccupancyGrid(const std::filesystem::path& yaml, Findings* findings = nullptr);

/** \brief Writes NAME.pgm and NAME.yaml, as ROS's map_saver does; each atomically, the image first. Cells
 * that are neither free nor occupied become unknown. Throws IoError. \param yaml path of the YAML file */
void writeOccupancyGrid(const std::filesystem::path& yaml, const OccupancyGrid& grid);

/** \brief The YAML file that a name given by a user stands for: itself if it ends in .yaml or .yml, map.yaml
 * in a folder, NAME.yaml else. */
std::filesystem::path occupancyGridPath(const std::filesystem::path& name);

}  // namespace facetloc
