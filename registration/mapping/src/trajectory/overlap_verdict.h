// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "motion/view_placing.h"

#include <facetloc/features/pose.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <map>
#include <optional>
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

/** \brief True if the depth of two views agrees at a relative pose. */
bool depthAgrees(const Eigen::Isometry3d& T_a_b, const View& a, const View& b);

/** \brief Share of the pixels of two views that agree or contradict at a relative pose. */
double overlapOf(const Eigen::Isometry3d& T_a_b, const View& a, const View& b);

enum class OverlapVerdict : char { says_nothing, confirms, contradicts };

/** \brief Verdict of two compared views on their relative pose by the trajectory. They contradict it if depth
 * disagrees there, or if they were registered farther away than 1 deg or 0.1 m and their error. */
OverlapVerdict verdictOn(const Eigen::Isometry3d& T_a_b, const View& a, const View& b,
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

}  // namespace facetloc::internal
