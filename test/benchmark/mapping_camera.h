// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "calibration/distortion_calibration.h"

#include <facetloc/features/local_model.h>
#include <facetloc/mapping/map_builder.h>

#include <optional>
#include <vector>

namespace facetloc::benchmarks {

/** \brief The distortion of the camera that made a map; the map's views are uncorrected. */
inline std::optional<DepthDistortion> distortionOf(const Map& map) {
  std::vector<PosedPicture> pictures;
  for (std::size_t i = 0; i < map.models.size(); ++i)
    pictures.push_back({&map.view(static_cast<int>(i))->depth, *map.models[i].T_w_m});
  const MapBuilderParams poses;
  const auto found = internal::calibrateDistortion(
      pictures, map.camera.noise, {poses.pose_rotation_std_deg * kDegree, poses.pose_translation_std});
  return found && found->reliable() ? std::make_optional(found->distortion) : std::nullopt;
}

}  // namespace facetloc::benchmarks
