// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/map_database.h>
#include <facetloc/mapping/map_making.h>

#include <filesystem>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Inputs of a map file that is built, so that only the same build goes on with it. */
struct MapInputs {
  std::string map;        ///< the file, in messages
  std::string recording;  ///< its path
  const DepthSequence& sequence;
  const std::vector<MapPlace>& places;
  std::string parameters;
  std::string disagreement;  ///< poses against images, in words; empty if unknown
};

/** \brief False for an empty file, too, which holds nothing that could be lost. */
bool isThere(const std::filesystem::path& path);

/** \brief Begins a map file. Throws IoError if it is there and may not be replaced. */
MapDatabase beginMap(const std::filesystem::path& path, const MapInputs& inputs, const Camera& camera,
                     bool overwrite);
/** \brief Opens a map file that the same build has begun; a file without local models is begun again.
 * Throws IoError if its local models are of other inputs. */
MapDatabase resumeMap(const std::filesystem::path& path, const MapInputs& inputs, const Camera& camera);

}  // namespace facetloc
