// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/pose_graph.h"
#include "motion/view_placing.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace facetloc::internal {

/** \brief Two keyframes, compared. */
struct Comparison {
  Eigen::Isometry3d prior = Eigen::Isometry3d::Identity();  ///< where they were expected
  bool anywhere = false;                                    ///< searched far from there, too
  std::optional<PlacedView> placed;
};

constexpr double kLeastAgreement = 0.8;  ///< share of the pixels in which two keyframes must agree
constexpr double kLeastOverlap = 0.2;    ///< share of the pixels that two keyframes must have in common
constexpr double kClearAgreement = 0.9;  ///< agreement of an image with the keyframes before it
constexpr double kLoopOverlap = 0.3;     ///< share that an uncertain loop must have in common
constexpr double kFarEllipsoid = chiSquareQuantile(6, 0.999);  ///< squared Mahalanobis distance

/** \brief Relative pose by two views, with the errors that all views share. */
PoseWithCovariance measured(const PlacedView& placed);

/** \brief ViewPlacing::place(); empty also if the two keyframes disagree, or have too little in common. */
std::optional<PlacedView> registered(const ViewPlacing& placing, const View& view, const View& other,
                                     const PoseWithCovariance& prior, bool search);

/** \brief True for views that agree clearly, as images of another place hardly do. */
bool isClear(const PlacedView& placed);

/** \brief Share of the pixels of two views that agree or contradict at a relative pose. */
double overlapOf(const Eigen::Isometry3d& T_a_b, const View& a, const View& b);

/** \brief Do two compared views confirm their relative pose by the trajectory? Nothing if they have too
 * little in common. They contradict it if depth disagrees there, or if they were registered farther away than
 * 1 deg or 0.1 m and their error. */
std::optional<bool> isConfirmed(const Eigen::Isometry3d& T_a_b, const View& a, const View& b,
                                const Comparison& compared);

/** \brief Numbers of two pieces of a trajectory, the smaller first. */
using PiecePair = std::pair<int, int>;
/** \brief Verdicts on the relative poses of pieces. */
using PieceVerdicts = std::map<PiecePair, OverlapVerdicts>;
/** \brief Independent ties between pieces. */
using PieceBonds = std::map<PiecePair, int>;

/** \brief The bond that is to be cut next, if any: one with too few independent ties, or else, where the
 * verdicts on two pieces contradict their relative pose, the one most contradicted among those that lead from
 * one to the other. Same input, same answer. */
std::optional<PiecePair> weakestBond(const PieceVerdicts& verdicts, const PieceBonds& bonds, int least_ties);

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

/** \brief The graph of a trajectory with the usual distance between its keyframes. \param mounting if known,
 * all stand on one floor */
PoseGraph keyframeGraph(const CameraTrajectory& trajectory, const std::optional<CameraMounting>& mounting);

/** \brief A place on a trajectory, as a keyframe knows it. */
struct PlaceOnTrajectory {
  int keyframe = 0;
  Eigen::Isometry3d T_k_c = Eigen::Isometry3d::Identity();  ///< pose in the frame of that keyframe
};

/** \brief Links between pairs of places, given by their indices, that are in one part: motions by the
 * trajectory's poses, covariances by its graph, computed for each pair separately. */
std::vector<Link> linksBetween(const CameraTrajectory& trajectory,
                               const std::vector<PlaceOnTrajectory>& places,
                               const std::set<std::pair<int, int>>& pairs);

/** \brief The links of a map whose local models are some images of a trajectory: from each to the next of its
 * part, and between those next to keyframes that were compared, which includes all closed loops.
 *
 * \param images numbers of the images in ascending order; link ends are indices among these. Throws
 * std::invalid_argument for a number that is no image's. */
std::vector<Link> trajectoryLinks(const CameraTrajectory& trajectory, const std::vector<std::size_t>& images);

}  // namespace facetloc::internal
