// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/trajectory.h>

#include <filesystem>
#include <vector>

/** \file
 * Where the poses of a recording are, and in which form. Private to io. */

namespace facetloc::internal {

/** \brief A text file with a pose of one image: a matrix of 4x4. */
struct PoseFile {
  double stamp = 0;
  std::filesystem::path path;
};

/** \brief The poses that a recording has with it; none by default. */
struct RecordedPoses {
  std::filesystem::path trajectory;  ///< in the TUM format; empty = the files of images, if there are any
  double seconds = 1;                ///< a stamp of the trajectory stands for so many
  std::vector<PoseFile> of_images;

  bool empty() const { return trajectory.empty() && of_images.empty(); }
  /** \brief Reads them all; of images whose pose was lost, which is written as a matrix that is not finite,
   * none. Throws IoError. */
  Trajectory read() const;
};

/** \brief Poses as of a camera whose y axis points down, given those of one whose y axis points up: the
 * world is seen as in a mirror, too. */
Trajectory mirrored(const Trajectory& poses);

/** \brief Poses whose stamps are later by so many seconds. */
Trajectory delayed(const Trajectory& poses, double seconds);

}  // namespace facetloc::internal
