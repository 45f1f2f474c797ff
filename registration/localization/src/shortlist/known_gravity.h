// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <mutex>
#include <optional>

namespace facetloc::internal {

/** \brief Gravity in the frames of a map's local models: as it was measured with their images, by the
 * mounting of the map's camera, or along a world whose z axis the planes of the map show to be vertical. */
class MapGravity {
public:
  explicit MapGravity(const Map& map) : map_(map) {}

  /** \brief Gravity in the frame of local model i. \param view of that model */
  std::optional<Gravity> of(int i, const View& view) const;

private:
  /** Reads some views at the first call. */
  bool isLevel() const;

  const Map& map_;
  mutable std::once_flag asked_;
  mutable bool is_level_ = false;
};

/** \brief Is the z axis of the world vertical: do cameras stand upright in it, and are nearly all planes
 * horizontal or vertical, with two directions of walls or a horizontal plane? Only poses that were given
 * count. */
bool isWorldLevel(const Map& map);

/** \brief Information about roll and pitch of T_m_c by gravity in both frames. \param down_m in the model */
Matrix6d gravityInformation(const Eigen::Vector3d& down_m, double std);

/** \brief A prior of T_m_c, corrected by gravity in both frames.
 * \param keeps_mean the mean moves by the correction only; otherwise both cameras are levelled first, and
 * have the same heading */
PoseWithCovariance correctedByGravity(const PoseWithCovariance& prior, const Gravity& of_model,
                                      const Gravity& of_view, bool keeps_mean);

}  // namespace facetloc::internal
