// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tools/app.h"

#include <facetloc/features/local_model.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/segmentation/view_builder.h>

#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief How depth images become views: what the tools that read images have in common. */
struct DepthInput {
  int width = 320;  ///< working width [px]; 0 = full size
  ViewParams view;

  void addOptions(CommandLine& line);
  /** \brief The parameters for images of this camera: its own noise, unless the user gave another. */
  ViewParams viewParams(const std::optional<CameraFile>& camera, const CommandLine& line) const;
};

/** \brief The same with the noise that camera.ini tells, if it does. */
ViewParams withNoiseOf(const std::optional<CameraFile>& camera, ViewParams params);

/** \brief The same for images that are localized in a map: what its camera was found to measure wrongly is
 * taken out of them, as it was out of the map's own images. */
ViewParams withDistortionOf(const Map& map, ViewParams params);

/** \brief The map as far as it holds for images of this camera, with a remark if it is unfinished: its
 * mounting says nothing about another one, and is dropped with a remark if theirs is another or not known.
 * Throws IoError. */
Map openMapFor(const std::optional<CameraFile>& camera, const std::string& path, const Console& console);

/** \brief The same for a map that is read already. */
void dropOtherMounting(const std::optional<CameraFile>& camera, Map& map, const Console& console);

/** \brief A remark if the build of the map at that path has not ended. */
void noteUnfinished(const Map& map, const std::string& path, const Console& console);

/** \brief A remark if images are much noisier than told: segmentation finds their noise by itself, but depths
 * are compared as exactly as told.
 * \param found inverse-depth noise of each image [1/m], 0 where it is not known */
void noteNoise(std::vector<double> found, const SensorNoise& told, const Console& console);

/** \brief Throws UsageError unless images and poses can be matched within this time [s]. */
void requireTolerance(double seconds);

/** \brief The options as "name = value" lines, for what is recorded beside maps and results. */
std::string toIni(const DepthInput& input, const ViewParams& view);

}  // namespace facetloc
