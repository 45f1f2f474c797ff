// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "inputs/depth_input.h"
#include "inputs/recording_run.h"

#include <facetloc/mapping/map_findings.h>
#include <facetloc/mapping/map_image.h>

#include <string>

namespace facetloc {

/** \brief An odometry, in the axes of the camera, interpolated between its poses: lines of JSON as
 * facetloc_live takes them (ROBOT.md), each with its stamp, or any file of poses, which are those of the
 * camera, or of its robot if the mounting is known; or a recording of messages. Empty for an empty name, with
 * a remark on how the poses were read. Throws IoError with file, line and cause. \param sequence whose images
 * it moves */
PosesByTime odometryByTime(const std::string& file, const DepthSequence& sequence,
                           const std::optional<CameraMounting>& mounting, const Console& console);

/** \brief Options and messages of the tools that find the trajectory of a camera from its images. */
class ImageTrajectory {
public:
  void addOptions(CommandLine& line);
  /** \brief The parameters as they are recorded in maps. */
  std::string toIni() const;
  const MappingParams& params() const { return params_; }

  /** \brief The odometry that is given, in the axes of the camera; empty without one. Throws IoError. */
  PosesByTime odometry(const DepthSequence& sequence, const Camera& camera, const Console& console) const;
  /** \brief Reports the obstacles to a trajectory from images. \return kFailed if images could not be read.
   * Throws IoError if no image can be read, and for an odometry that does not belong to the images. */
  int report(const MapFindings& findings, const DepthSequence& sequence, const Console& console) const;

private:
  std::string odometry_;
  MappingParams params_;
};

/** \brief "way 12.3 m, 44 keyframes, 5 loops closed, 1 piece". */
std::string toString(const CameraTrajectory& trajectory);

}  // namespace facetloc
