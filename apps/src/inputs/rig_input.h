// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/depth_input.h"

#include <facetloc/io/rig_file.h>
#include <facetloc/mapping/map_image.h>
#include <facetloc/registration/pose_prior.h>

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

/** \brief Makes the views of the first camera of a rig, joined with those of the others at the same moment:
 * their nearest images within 0.1 s. The motion between two images is the odometry's, or else unknown, of a
 * walk. One per thread. */
class RigViews {
public:
  /** \param sequence of the first camera; this and the sides must outlive it \param odometry of the first
   * camera, T_o_c; may be empty */
  RigViews(const DepthSequence& sequence, const Camera& camera, const std::vector<SideRecording>& sides,
           const DepthInput& input, PosesByTime odometry, const OdometryError& error);
  /** \brief The view of an image of the first camera; the view itself without others. */
  View at(std::size_t image, const std::optional<Gravity>& gravity);
  /** \brief Time for the segments of the last view, with all for the others' [ms]. */
  double segmentMilliseconds() const { return builder_.segmentMilliseconds() + sides_milliseconds_; }
  double featuresMilliseconds() const { return builder_.featuresMilliseconds(); }

private:
  PoseWithCovariance motion(double from, double to) const;

  const DepthSequence& sequence_;
  const std::vector<SideRecording>& sides_;
  int width_;
  ViewBuilder builder_;
  std::vector<ViewBuilder> side_builders_;
  PosesByTime odometry_;
  OdometryError error_;
  double sides_milliseconds_ = 0;
};

}  // namespace facetloc
