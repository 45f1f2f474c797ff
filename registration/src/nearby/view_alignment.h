// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/dense_refinement.h"
#include "depth/depth_consistency.h"

#include <facetloc/features/local_model.h>
#include <facetloc/registration/hypothesis.h>
#include <facetloc/registration/registration_params.h>

#include <memory>
#include <vector>

namespace facetloc::internal {

/** \brief The views of one place, as one: a view shares some planes with one of them and some with another.
 */
struct LocalMap {
  /** \brief Where a segment comes from. */
  struct Origin {
    int view = 0;     ///< index among the views
    int segment = 0;  ///< index in that view
  };
  std::vector<Segment> segments;                   ///< segments of all views, in world axes
  std::vector<Origin> origins;                     ///< origin of each segment
  std::vector<PosedPicture> pictures;              ///< pictures of the views that have one
  std::vector<PosedPicture> sides;                 ///< other pictures of joined views, each once
  std::vector<std::shared_ptr<const View>> views;  ///< whose pictures these are

  /** \brief Adds view number `index`, taken at T_w_c. */
  void add(int index, std::shared_ptr<const View> view, const Eigen::Isometry3d& T_w_c);
  /** \brief The pictures whose cameras look as one at T_w_c; all if none does. */
  std::vector<PosedPicture> picturesNear(const Eigen::Isometry3d& T_w_c) const;
};

/** \brief How a view is aligned with its surroundings. */
struct ViewAlignmentParams {
  MatchingParams matching;
  DenseRefinementParams dense;
  bool as_shown = false;  ///< information counts as far as the cost shows it (shownInformation)
};

constexpr double kCorrelatedPixels = 200;  ///< depth pixels that count as one independent measurement
constexpr double kSignificance = 2;        ///< least information of a direction [the gradients' noise]

/** \brief Alignment where the covariance counts: errors of neighbouring pixels are correlated, and directions
 * without significant information are left to the prior (METHOD 11). */
ViewAlignmentParams alignmentWithCovariance(bool as_shown = false, const MatchingParams& matching = {});

/** \brief Covariance of a pose about the start of an alignment that begins near its end: 3 deg, 0.1 m. */
Matrix6d aboutStart();

/** \brief Where a view is in its surroundings. */
struct ViewAlignment {
  PoseWithCovariance T_w_c;
  std::vector<SegmentPair> pairs;  ///< (segment of the view, segment of the surroundings)
  bool dense = false;              ///< depth pixels took part
};

/** \brief Aligns a view with its surroundings: first all planes that they have in common (refineJointly),
 * then all pixels (refineByDepth), which also see curved surfaces.
 *
 * \param prior T_w_c and its covariance
 * \return the pose with the covariance of everything; the prior where nothing is in common. */
ViewAlignment alignView(const View& view, const LocalMap& surroundings, const PoseWithCovariance& prior,
                        const ViewAlignmentParams& params);

/** \brief Combined verdicts of several pictures on each pixel of one, on a grid with this number of columns:
 * contradicted if more of them contradict than agree, else agreed if one agrees. */
DepthAgreement compareWithAll(const DepthPicture& scene, const Eigen::Isometry3d& T_w_c,
                              const std::vector<PosedPicture>& others, const DepthComparison& comparison,
                              int columns);

/** \brief How far apart two cameras can be that have much in common. */
struct ViewReach {
  double distance;  ///< distance of their centres [m]
  double angle;     ///< angle between their viewing directions [rad]
};
constexpr ViewReach kTrackingReach{4, 60 * kDegree};
/** \brief Reach of the views that may show the surfaces of a scene. */
constexpr ViewReach kEvidenceReach{2.5, 50 * kDegree};

/** \brief Distance of two cameras by their views [m]: the distance of their centres, and 1.5 m per radian
 * between their viewing directions (METHOD 8.4); infinite beyond the reach. */
double viewDistance(const Eigen::Isometry3d& T_w_a, const Eigen::Isometry3d& T_w_b,
                    const ViewReach& reach = kTrackingReach);

}  // namespace facetloc::internal
