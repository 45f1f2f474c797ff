// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/graph_covariance.h"
#include "trajectory/camera_speed.h"

#include <facetloc/features/local_model.h>

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace facetloc::internal {

/** \brief A keyframe, as far as the search for ties needs it. */
struct TieEnd {
  std::shared_ptr<const View> view;
  int part = 0;
  int run = 0;  ///< number of interruptions before it
  double stamp = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< position in the world of its part
};

/** \brief How pairs of keyframes are searched for. */
struct TieSearch {
  PoseWithCovariance prior;                ///< relative pose of a pair, about the identity
  std::optional<CameraMounting> mounting;  ///< with it, a PlaceIndex bounds the search
  int threads = 1;                         ///< 0 = all cores
  std::function<void(double)> progress{};  ///< receives the share of the work that is done; may be empty
  /// pairs up to which all are compared: an index costs as much as 6000 comparisons for each keyframe
  long long exhaustive_up_to = 20'000'000;
};

/** \brief Pairs of keyframes of different parts that may show the same place: those close in order, and for
 * each keyframe the earlier ones whose planes overlay best (localization/METHOD 13.7). Of many keyframes with
 * a known mounting, only the most similar ones by a PlaceIndex are overlaid.
 *
 * \param first number of the first keyframe that pairs are formed with */
std::vector<std::pair<int, int>> tieCandidates(const std::vector<TieEnd>& keyframes, int first,
                                               const TieSearch& search);

/** \brief Bound on ties by the distance that the camera may have covered between two parts. */
class TravelBound {
public:
  TravelBound(const std::vector<TieEnd>& keyframes, const CameraSpeed& speed, const GraphCovariance& graph);

  /** \brief False if the camera would have had to move much faster than it does. Anything is possible across
   * an interruption. */
  bool allows(const PoseEdge& tie) const;

private:
  std::pair<int, int> nearestInTime(int part_a, int part_b) const;
  double farthest(int first, int last) const;

  const std::vector<TieEnd>& keyframes_;
  const CameraSpeed& speed_;
  const GraphCovariance& graph_;
};

}  // namespace facetloc::internal
