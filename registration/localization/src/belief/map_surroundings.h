// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "nearby/nearby_models.h"
#include "nearby/view_alignment.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/features/pose.h>

#include <memory>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief A floor near some place. */
struct FloorPlane {
  Eigen::Isometry3d T_w_f = Eigen::Isometry3d::Identity();  ///< its frame: z = 0 on the floor, z upwards
  /// Covariance of (slope along x, slope along y, height at the origin) [1, 1, m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/** \brief The floor that fits best under robots that have stood on it, seen from a place near them.
 *
 * Each robot tells the slope of the floor by its own and its height where it stands, as well as the floor is
 * even; the farther from the place, the less that height counts, for a floor is no perfect plane.
 *
 * \param T_w_c cameras of the robots, at least one
 * \param covariance of (roll, pitch, height) of a robot about its floor, 3x3, regular (floorCovariance()) */
FloorPlane floorUnder(const std::vector<Eigen::Isometry3d>& T_w_c, const CameraMounting& mounting,
                      const Eigen::Matrix3d& covariance, const Eigen::Vector3d& place);

/** \brief Kalman update of a camera's pose by the floor that its robot stands on, which fixes the motions
 * that a bare wall leaves free: roll, pitch and height.
 *
 * \param T_w_c the camera and its covariance
 * \param covariance of (roll, pitch, height) of the robot about that floor, 3x3, regular
 * \param repeated number of updates that count as one, as their errors are equal: >= 1 */
PoseWithCovariance updatedByFloor(const PoseWithCovariance& T_w_c, const CameraMounting& mounting,
                                  const FloorPlane& floor, const Eigen::Matrix3d& covariance,
                                  double repeated = 1);

/** \brief Finds the local models of a map that surround a pose. */
class MapSurroundings {
public:
  MapSurroundings(std::shared_ptr<const Map> map, const DepthComparison& comparison);
  const Map& map() const { return *map_; }
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
