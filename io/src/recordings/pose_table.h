// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/name_numbers.h"

#include <facetloc/io/trajectory.h>

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace facetloc::internal {

/** \brief A name of a column in lower case, and the unit in brackets behind it. */
struct ColumnName {
  std::string word, unit;

  bool has(const char* part) const { return word.find(part) != std::string::npos; }
  bool begins(const char* part) const { return word.rfind(part, 0) == 0; }
  char last() const { return word.empty() ? ' ' : word.back(); }
  bool isStamp() const;
  /** \brief Seconds that a stamp of that name stands for; 0 if the name does not say it. */
  double seconds() const;
};

/** \brief The cells between commas or semicolons, if there are any, or else between blanks; "[ns]" belongs to
 * the cell before. */
std::vector<ColumnName> columnNames(std::string_view line);

/** \brief One pose of a file. */
struct PoseRow {
  double stamp = 0;                        ///< as it is written, if the table is stamped
  std::optional<Eigen::Isometry3d> T_w_c;  ///< none: lost, which trackers write as NaN or zeros
};

/** \brief The poses of a file, in its order. */
struct PoseTable {
  std::vector<PoseRow> rows;
  bool stamped = true;
  TimeUnit unit;  ///< unit of the stamps, by the header of the table or by their size

  std::size_t lost() const;
  std::vector<double> stamps() const;
};

/** \brief The pose of one image in a file of its own: a matrix of 4x4 or 3x4, or `tx ty tz qx qy qz qw`.
 * Nothing if it was lost, and has numbers that are not finite. Throws IoError. */
std::optional<Eigen::Isometry3d> readPoseOfImage(const std::filesystem::path& path);

/** \brief The same of 7, 12 or 16 numbers that are there. \param source named in errors */
std::optional<Eigen::Isometry3d> poseOfNumbers(std::vector<double> numbers,
                                               const std::filesystem::path& source);

/** \brief Reads rows of numbers between blanks, commas or semicolons, with decimal points or commas; # and %
 * start comments, and a line of names may come first and name the columns. Without one, rows are
 * `tx ty tz qx qy qz qw` or a matrix of 12 or 16 numbers by rows, with or without a stamp in front, as of
 * TUM, KITTI and Replica; of 8 with a number behind or in front, as of RTAB-Map; of 17 as of EuRoC; or
 * matrices of 4x4 one after the other, as of Redwood. Throws IoError with the line. */
PoseTable readPoseTable(const std::filesystem::path& path);

/** \brief The same of text that is there. \param source named in errors */
PoseTable parsePoseTable(std::string_view content, const std::string& source);

/** \brief The words of a text as numbers. Throws IoError. \param path in errors */
std::vector<double> numbersOf(std::string_view content, const std::filesystem::path& path);

/** \brief The rigid transform of a matrix that is one up to 1e-2, as files have as few as four decimals.
 * Throws std::invalid_argument. \param subject of its message */
Eigen::Isometry3d poseOfMatrix(const Eigen::Matrix4d& m, const std::string& subject = "its pose ");

/** \brief A pose of seven numbers, tx ty tz qx qy qz qw; none if it was lost: not finite, or a quaternion of
 * zeros. Throws std::invalid_argument. */
std::optional<Eigen::Isometry3d> poseOfColumns(const std::array<double, 7>& columns);

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
