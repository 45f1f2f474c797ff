// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/app.h"
#include "base/depth_input.h"

#include <facetloc/io/trajectory.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <string>
#include <vector>

namespace facetloc {

/** \brief A trajectory, and what was in the way. */
struct FoundTrajectory {
  CameraTrajectory trajectory;        ///< a pose for each image of the sequence
  std::vector<std::string> failures;  ///< name and cause of each image that could not be read

  /** \brief Lists the failures on console.err. \return kFailed if there are any, else kOk. */
  int report(const Console& console) const;
};

/** \brief Finds the trajectory of a camera from its images: options and messages of the tools that do so. */
class ImageTrajectory {
public:
  void addOptions(CommandLine& line);
  /** \brief The parameters as they are recorded in maps. */
  std::string toIni() const;

  /** \brief The trajectory of all images that can be read; those that cannot are where they are between the
   * others. Shows progress. Throws IoError if no image can be read, and for an odometry that has nothing to
   * do with the images. */
  FoundTrajectory find(const DepthSequence& sequence, const DepthInput& input, const Camera& camera,
                       int threads, const Console& console) const;

private:
  Trajectory odometry(const DepthSequence& sequence, const Camera& camera) const;
  void noteOdometry(const CameraTrajectory& found, const Trajectory& odometry, const Console& console) const;

  std::string odometry_;
  MappingParams params_;
};

/** \brief "way 12.3 m, 44 keyframes, 5 loops closed, 1 piece". */
std::string inWords(const CameraTrajectory& trajectory);

}  // namespace facetloc
