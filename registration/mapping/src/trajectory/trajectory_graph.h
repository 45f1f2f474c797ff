// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/pose_graph.h"
#include "motion/view_placing.h"
#include "trajectory/overlap_verdict.h"

#include <facetloc/mapping/trajectory_estimation.h>

#include <algorithm>

namespace facetloc::internal {

/** \brief Position of an image relative to a keyframe. */
struct RelativePosition {
  PoseWithCovariance by_motion;                         ///< pose without a comparison with that keyframe
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();  ///< pose by all information
  bool known = true;                                    ///< false after a break of the chain of motions
  bool guessed = false;                                 ///< by_motion is a prior of camera motion alone
  bool follows = true;                                  ///< odometry is right
  std::optional<PlacedView> placed;                     ///< comparison with that keyframe, if they agree
  std::vector<AlternativeMotion> others;                ///< motions that this comparison leaves open
};

/** \brief A keyframe, and how it was reached. */
struct TrajectoryNode : Keyframe {
  double stamp = 0;     ///< [s]
  int run = 0;          ///< number of interruptions before it
  int before = 0;       ///< keyframe that the path led from
  RelativePosition at;  ///< position relative to that keyframe, as found with the image
  int piece = 0;        ///< number of the first keyframe that motions led from; set by the graph
};

/** \brief The graph of keyframes: poses, motions between them as weighted edges, and their solution. */
class TrajectoryGraph {
public:
  explicit TrajectoryGraph(const ViewOdometryParams& params) : params_(params) {}

  int size() const { return static_cast<int>(nodes_.size()); }
  const std::vector<TrajectoryNode>& nodes() const { return nodes_; }
  const TrajectoryNode& operator[](int k) const { return nodes_[static_cast<std::size_t>(k)]; }
  /** \brief Motions by comparisons of keyframes. */
  const std::vector<KeyframeMotion>& relations() const { return relations_; }
  /** \brief All motions: the chain of consecutive keyframes, and the relations. */
  std::vector<KeyframeMotion> motions() const;
  /** \brief T_a_b by the poses. */
  Eigen::Isometry3d between(int a, int b) const { return (*this)[a].T_w_c.T.inverse() * (*this)[b].T_w_c.T; }
  PiecePair piecesOf(int a, int b) const { return std::minmax((*this)[a].piece, (*this)[b].piece); }
  std::optional<CameraMounting> mounting() const;
  /** \brief Motion of the camera to the next image, if nothing was measured. */
  PoseWithCovariance guessedStep() const;
  PoseGraph poseGraph() const;

  /** \brief Adds a keyframe at its known position, or as the first one of a part. */
  void add(TrajectoryNode node);
  /** \brief Adds the relations that stay next to newly found ones: those of keyframes before the first that
   * was compared, loops, and relations of a keyframe with the one that led to it. */
  void keepRelations(int first, std::vector<KeyframeMotion>& found) const;
  /** \brief Replaces the relations, without those that the others or the depth at the solution contradict.
   * \return the farthest that a keyframe has moved [m] */
  double optimize(std::vector<KeyframeMotion> found);
  /** \brief Takes the poses and relations of an improved copy; later keyframes move with those before. */
  void adopt(const TrajectoryGraph& improved);

private:
  bool slides(const CameraMounting& mounting) const;
  void follow(TrajectoryNode& node) const;
  void alignParts();

  ViewOdometryParams params_;
  std::vector<TrajectoryNode> nodes_;
  std::vector<KeyframeMotion> relations_;
};

}  // namespace facetloc::internal
