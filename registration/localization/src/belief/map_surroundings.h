// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "belief/floor_update.h"
#include "nearby/nearby_models.h"
#include "nearby/view_alignment.h"

#include <memory>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief Finds the local models of a map that surround a pose. */
class MapSurroundings {
public:
  MapSurroundings(std::shared_ptr<const Map> map, const DepthComparison& comparison);
  const Map& map() const { return *map_; }
  /** \brief False if no local model has a pose: nothing surrounds anything then. */
  bool anyPose() const { return !near_.empty(); }
  /** \brief The at most n nearest models of a part of the map by viewDistance() that confirm some of a view
   * taken about at T_w_c, nearest first; if they are fewer, then the nearest others. Indices are those in the
   * map. A model that confirms next to nothing, because it is behind a wall, gives its planes but no picture.
   */
  LocalMap around(const View& view, int part, const Eigen::Isometry3d& T_w_c, int n) const;
  /** \brief The floor under a camera and the n models next to it (floorUnder()). Models on another storey or
   * step do not count, since their robots stand higher or lower; nothing without any other, or without a
   * known camera mounting. */
  std::optional<FloorPlane> floorNear(int part, const Eigen::Isometry3d& T_w_c, int n,
                                      const Eigen::Matrix3d& covariance) const;

private:
  std::shared_ptr<const Map> map_;
  DepthComparison comparison_;
  NearbyModels near_;
};

}  // namespace facetloc::internal
