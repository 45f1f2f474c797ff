// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/message_log.h"

#include <facetloc/io/trajectory.h>

#include <Eigen/Geometry>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/** \file
 * The frames of a robot, as tf has them. Private to io. */

namespace facetloc::internal {

/** \brief Transforms of a recording: of tf and tf_static. Those that never change are fixed, whoever
 * publishes them. */
class FrameTree {
public:
  /** \brief Reads all transforms, but for those of corrupt messages. */
  explicit FrameTree(const MessageLog& log);
  /** \brief The messages that were left out; empty if none was. */
  const std::string& faults() const { return faults_; }

  /** \brief T_a_b, by fixed transforms alone; the identity if they are one frame. Nothing if they are not
   * connected. */
  std::optional<Eigen::Isometry3d> fixed(const std::string& a, const std::string& b) const;

  /** \brief The poses of a frame that moves. */
  struct Moving {
    std::string parent, child;
    std::vector<StampedPose> poses;  ///< T_parent_child
  };
  /** \brief The frame whose parent is `odom`, or else the one frame that moves above another. Empty
   * without one, or with several. \param below the frame that it has to be above, or empty */
  std::optional<Moving> moving(const std::string& below) const;

private:
  using Edge = std::pair<std::string, std::string>;  // parent, child
  bool isFixed(const Edge& edge) const;
  std::map<Edge, std::vector<StampedPose>> transforms_;
  std::string faults_;
};

}  // namespace facetloc::internal
