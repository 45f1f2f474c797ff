// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/pose.h>

#include <filesystem>
#include <optional>
#include <vector>

namespace facetloc {

/** \brief The rig.ini of several cameras on one robot: one `key = value` per line, # starts a comment.
 *
 *     cameras = front left rear    their folders, each with the images and the camera.ini of one camera
 *     rotation_std_deg = 0.5       errors of their mountings against the first one's, standard deviation
 *     translation_std = 0.01       [m]
 *
 * The pose of the robot's view is the pose of the first camera. Each camera.ini has a mounting (mount_...).
 * The errors may be left out; these are their defaults. */
struct RigFile {
  std::vector<std::filesystem::path> cameras;  ///< folders, the first one's first; at least two
  double rotation_std = 0.5 * kDegree;         ///< [rad]
  double translation_std = 0.01;               ///< [m]

  /** \brief T_first_c of another camera, by the mountings of both, with the covariance of the errors. */
  PoseWithCovariance between(const CameraMounting& first, const CameraMounting& other) const;
};

/** \brief The rig.ini at a path, a file of this name or a folder with one; nothing for other paths. Throws
 * IoError with the line for unknown keys, values that are impossible, and fewer than two cameras. */
std::optional<RigFile> readRigFile(const std::filesystem::path& path);

}  // namespace facetloc
