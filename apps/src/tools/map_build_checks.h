// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/mapping/map_making.h>

#include <string>

namespace facetloc {

/** \brief Checks and remarks of facetloc_map build. */
struct MapBuildChecks {
  const DepthSequence& sequence;
  const Trajectory& given;  ///< poses of the images; empty if none are given
  const Console& console;
  std::string recording;  ///< its path
  std::string poses;      ///< path of their file; empty for those of the recording
  double pose_tolerance;  ///< [s]
  bool force;             ///< faults are remarks

  /** \brief Reports faults of the reading of images. Throws IoError if they cannot be right. */
  void checkReading(MapMaking& making) const;
  /** \brief Reports how much the poses disagree with the images, and likely causes. \return the
   * disagreement in words, empty if unknown. Throws IoError if no map can be made of such poses. */
  std::string checkPoses(MapMaking& making) const;
  /** \brief Poses that fit few images and cannot be checked may be those of other images, by an invalid
   * clock: throws IoError. */
  void requireMostPosed(const MapMaking& making) const;
  void noteTrajectory(const CameraTrajectory& trajectory) const;
  void noteDistortion(const MapFindings& findings) const;
  /** \brief A remark on images without a pose, unless none was given. */
  void noteWithoutPose(const MapMaking& making) const;

private:
  std::size_t withoutPose(const MapMaking& making) const;
};

}  // namespace facetloc
