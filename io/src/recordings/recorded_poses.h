// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/name_numbers.h"
#include "recordings/pose_table.h"

#include <facetloc/io/pose_reading.h>
#include <facetloc/io/trajectory.h>

#include <filesystem>
#include <string>
#include <vector>

/** \file
 * Where the poses of a recording are, and whose they are. Private to io. */

namespace facetloc::internal {

/** \brief A text file with a pose of one image: a matrix of 4x4. */
struct PoseFile {
  double stamp = 0;
  std::filesystem::path path;
};

/** \brief Poses, and a remark on how they were read: a sentence without full stop, or nothing. */
struct ReadPoses {
  Trajectory poses{};
  std::string remark{};
};

/** \brief The times of images, and the numbers that these are from. */
struct ImageTimes {
  std::vector<double> stamps;   ///< [s], or indices
  std::vector<double> numbers;  ///< numbers in their names or their list, sorted by stamp; or empty
  TimeUnit unit;                ///< unit of the numbers
};

/** \brief The poses that a recording has with it; none by default. */
struct RecordedPoses {
  std::filesystem::path trajectory;  ///< one file of all poses
  double seconds = 0;                ///< that a stamp of the trajectory stands for; 0 = as the file says
  std::vector<PoseFile> of_images;
  std::vector<StampedPose> listed;  ///< beside the images in their list

  bool empty() const { return trajectory.empty() && of_images.empty() && listed.empty(); }
  /** \brief Reads them all; lost ones are left out. Throws IoError. */
  ReadPoses read(const ImageTimes& images) const;
};

/** \brief Do the stamps of poses have most of the numbers of the images? Then they are of one kind. */
bool haveSameNumbers(const PoseTable& table, const ImageTimes& images);

/** \brief The poses of a file at the times of the images: by their stamps in the unit of the file, or in that
 * of the images' numbers where these are the same; rows without stamps, or of images that are only
 * counted, by their order. Throws IoError if poses cannot be assigned to images. \param path in errors */
ReadPoses matched(const PoseTable& table, const ImageTimes& images, const std::filesystem::path& path);

/** \brief The poses of a file at the stamps that it has. Throws IoError if it has none. */
ReadPoses stampedPoses(const PoseTable& table, const std::filesystem::path& path);

/** \brief Poses as of a camera whose y axis points down, given those of one whose y axis points up: the
 * world is also mirrored. */
Trajectory mirrored(const Trajectory& poses);

/** \brief Poses with this time added to their stamps [s]. */
Trajectory delayed(const Trajectory& poses, double seconds);

/** \brief Poses of the camera's optical frame in the world, from poses in another convention.
 * \param T_b_c the camera on its robot, where its mounting is known */
Trajectory readAs(const PoseReading& reading, const Trajectory& poses,
                  const std::optional<Eigen::Isometry3d>& T_b_c);

}  // namespace facetloc::internal
