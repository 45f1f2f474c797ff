// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace facetloc {

/** \brief A pose T_w_c of the camera optical frame in the world at a time [s]. */
struct StampedPose {
  double stamp = 0;
  Eigen::Isometry3d T_w_c = Eigen::Isometry3d::Identity();
};

/** \brief Poses sorted by time. */
class Trajectory {
public:
  Trajectory() = default;
  explicit Trajectory(std::vector<StampedPose> poses);
  const std::vector<StampedPose>& poses() const { return poses_; }
  bool empty() const { return poses_.empty(); }
  /** \brief The pose at a time: interpolated() between two poses that are at most five tolerances apart, or
   * else the pose nearest in time, if it lies within the tolerance [s]. A camera whose motion changes by a
   * leaves the even motion between poses that are T apart by at most a T^2 / 8: 1.3 mm for 1 m/s^2 and the
   * tolerance that is the default. */
  std::optional<Eigen::Isometry3d> at(double stamp, double tolerance = 0.02) const;
  /** \brief The pose at a time between two poses, of which the motion is even between them; nothing before
   * the first and after the last. */
  std::optional<Eigen::Isometry3d> interpolated(double stamp) const;

private:
  using Poses = std::vector<StampedPose>;
  Poses::const_iterator notBefore(double stamp) const;
  std::optional<Eigen::Isometry3d> nearest(double stamp, double tolerance) const;

  Poses poses_;
};

/** \brief Reads poses with time stamps in common forms: the TUM format with blanks, commas or
 * semicolons between the columns, with a line of names, with a number behind each pose; EuRoC's; a stamp and
 * a matrix of 12 or 16 numbers. Stamps in milliseconds, microseconds or nanoseconds are known by a header or
 * by their size. Lost poses, NaN or a quaternion of zeros, are left out. Throws IoError with the line number.
 * \param remark receives assumptions and omissions, or nothing */
Trajectory readTrajectory(const std::filesystem::path& path, std::string* remark = nullptr);

/** \brief Writes the TUM format: a header line, stamps with 6 decimals, exactly 8 columns, no trailing space.
 */
void writeTumTrajectory(const std::filesystem::path& path, const std::vector<StampedPose>& poses);

/** \brief How the poses of a recording are written, where it is not as facetloc takes them: of the camera's
 * optical frame (x right, y down, z forward) in the world, quaternions in the order x y z w. */
struct PoseReading {
  enum class Axes {
    optical,  ///< x right, y down, z forward
    base,     ///< pose of the robot, by its mounting if that is known, or else x forward, y left, z up
    opengl,   ///< x right, y up, z backward, as of ARKit and Blender
  };
  bool w_first = false;  ///< quaternions are in the order w x y z
  bool inverse = false;  ///< they are of the world in the camera
  Axes axes = Axes::optical;

  /** \brief "auto", or some of "wxyz", "inverse", "base", "opengl" with commas between them. Throws
   * std::invalid_argument with a sentence for anything else. */
  static PoseReading of(std::string_view words);
  bool isUsual() const { return !w_first && !inverse && axes == Axes::optical; }
};

}  // namespace facetloc
