// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/depth_input.h"

#include <facetloc/io/rig_file.h>
#include <facetloc/registration/pose_prior.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief The recording of another camera beside the first one of a rig. */
struct SideRecording {
  DepthSequence sequence;
  Camera camera;
  PoseWithCovariance T_first_c;
};

/** \brief The recordings of all cameras of a rig but the first one's. Throws IoError for a camera without a
 * mounting. \param first camera of the first one */
std::vector<SideRecording> openSides(const RigFile& rig, const Camera& first, const DepthInput& input,
                                     const CommandLine& line, const Console& console);

/** \brief T_first_c of each, as mapForRig() takes them. */
std::vector<Eigen::Isometry3d> posesOf(const std::vector<SideRecording>& sides);

/** \brief The rig as it is recorded beside results: a comment of a file of parameters. */
std::string rigLine(const RigFile& rig);

/** \brief Joins views of the first camera of a rig with those of the others at the same moment: their nearest
 * images within 0.1 s. The motion between two images is the odometry's, or else unknown, of a walk. One per
 * thread. */
class SideViews {
public:
  /** \param sides must outlive it \param odometry of the first camera, T_o_c; may be empty */
  SideViews(const std::vector<SideRecording>& sides, const DepthInput& input,
            std::function<std::optional<Eigen::Isometry3d>(double stamp)> odometry,
            const OdometryError& error, const std::optional<CameraMounting>& mounting);
  /** \brief The view itself without others. \param stamp of the view [s] */
  View joinedTo(View first, double stamp);
  /** \brief Time for making the others' views of the last one [ms]. */
  double milliseconds() const { return milliseconds_; }

private:
  PoseWithCovariance motion(double from, double to) const;

  const std::vector<SideRecording>& sides_;
  std::vector<ViewBuilder> builders_;  // one per side
  int width_;
  std::function<std::optional<Eigen::Isometry3d>(double)> odometry_;
  OdometryError error_;
  std::optional<CameraMounting> mounting_;
  double milliseconds_ = 0;
};

}  // namespace facetloc
