// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace facetloc::internal {

/** \brief An image that is a local model, as known to the keyframe that it is attached to. */
struct MappedPlace {
  std::string name;
  double stamp = 0;  ///< [s]
  int keyframe = 0;
  Eigen::Isometry3d T_k_m = Eigen::Isometry3d::Identity();
  std::shared_ptr<const View> view;  ///< without its depth picture
};

/** \brief The images of a trajectory that are local models: by the rule of MapBuilder, but where there is one
 * already, no other. Their poses are those that the trajectory has now. */
class MappedPlaces {
public:
  explicit MappedPlaces(const MapBuilderParams& params = {}) : params_(params) {}

  /** \brief To be called after each image that the trajectory takes. \return true if it is a local model. */
  bool visit(const TrajectoryEstimation& trajectory, const View& view, const std::string& name, double stamp);
  const std::vector<MappedPlace>& places() const { return places_; }

  /** \brief T_w_m of each place of a part of the trajectory, given by its first keyframe; nothing for others.
   */
  std::vector<std::optional<Eigen::Isometry3d>> poses(const TrajectoryEstimation& trajectory, int part) const;
  /** \brief Links from each place to those next on the way, and between those whose keyframes have closed
   * a loop. */
  std::vector<Link> links(const CameraTrajectory& trajectory) const;

private:
  std::optional<int> near(const TrajectoryEstimation& trajectory, int part, const Eigen::Isometry3d& T) const;

  MapBuilderParams params_;
  std::vector<MappedPlace> places_;
  std::set<std::pair<int, int>> next_;  // numbers of places, the lower one first
  std::optional<int> latest_;
};

}  // namespace facetloc::internal
