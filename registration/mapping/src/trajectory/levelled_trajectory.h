// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/gravity.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <cstddef>
#include <functional>
#include <optional>

namespace facetloc::internal {

/** \brief Rotates each part of a trajectory so that the z axis of its world points upwards, by the gravity
 * that was measured with its images; parts without any stay. \param gravity of an image, in its optical frame
 */
void levelTrajectory(const std::function<std::optional<Gravity>(std::size_t image)>& gravity,
                     CameraTrajectory& trajectory);

}  // namespace facetloc::internal
