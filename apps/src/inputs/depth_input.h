// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/features/image_noise.h>
#include <facetloc/features/local_model.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/mapping/map_findings.h>
#include <facetloc/segmentation/view_builder.h>

#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief The options of all tools that read recordings: facts that the files do not contain. */
void addRecordingOptions(CommandLine& line, RecordingHints& recording);
/** \brief One of them, for tools that read poses and no images. */
void addTimeOffset(CommandLine& line, double& seconds);

/** \brief How depth images become views, for all tools that read images. */
struct DepthInput {
  int width = 320;  ///< working width [px]; 0 = full size
  SensorNoise noise;
  ViewParams view;
  RecordingHints recording;

  void addOptions(CommandLine& line);
  /** \brief These, after those of recordings. */
  void addAllOptions(CommandLine& line) {
    addRecordingOptions(line, recording);
    addOptions(line);
  }
  /** \brief The camera of images: as its camera.ini says, if there is one, but for the noise that the user
   * has given. */
  Camera camera(const std::optional<CameraFile>& file, const CommandLine& line) const;
};

/** \brief The images at a path, or with RecordingHints::segments their segments, with the findings of
 * reading them. Throws IoError. */
DepthSequence openSequence(const std::string& path, const RecordingHints& hints, const Console& console);

/** \brief The view of an image of a sequence: built from its depth, or read from its file of segments and
 * without depth. */
View viewOf(const DepthSequence& sequence, std::size_t index, int working_width, ViewBuilder& builder,
            const std::optional<Gravity>& gravity = {});

/** \brief The map of a file or, named by their files, several maps as one (joinMaps()); unfinished ones are
 * noted. Throws IoError. */
std::shared_ptr<const Map> openMaps(const std::vector<std::string>& paths, const Console& console);
/** \brief The map of that path, with a remark if its build has not ended. */
Map noteUnfinished(Map map, const std::string& path, const Console& console);

/** \brief Prints how the camera of the images differs from the map's. */
void noteDifference(const Camera& of_images, const Map& map, const Console& console);

/** \brief A remark if images are much noisier than their camera's specification.
 * \param found noise of inverse depth of each image at the usual depth [1/m], 0 where it is not known */
void noteNoise(std::vector<double> found, const SensorNoise& specified, const Console& console);

/** \brief Prints noise over range as a table, and the lines of a camera.ini that say it. Requires one bin. */
void printNoise(std::ostream& out, const std::vector<NoiseBin>& bins);

/** \brief The option of tools that match images with poses. */
void addPoseTolerance(CommandLine& line, double& seconds);
/** \brief The poses of a file, or those of the recording without one, with a remark on how they were read.
 * Throws IoError. */
Trajectory givenPoses(const DepthSequence& sequence, const std::string& file, const Console& console);

/** \brief The options as they are recorded beside maps and results; plain ones first. */
std::string toIni(const DepthInput& input, const Camera& camera);

}  // namespace facetloc
