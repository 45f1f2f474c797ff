// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/depth_distortion.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A depth camera, and all that is known of it: one value, which views and maps carry along. */
struct Camera {
  Intrinsics intrinsics;  ///< intrinsics of full images; not valid() while each image has its own
  SensorNoise noise;      ///< specified noise; an image that is noisier has its own
  std::optional<CameraMounting>
      mounting;  ///< on a robot that drives on a floor; none = in the hand, or unknown
  std::optional<DepthDistortion> distortion;  ///< systematic depth errors, removed from its images
  double max_depth = std::numeric_limits<double>::infinity();  ///< farther pixels count as not measured [m]
};

/** \brief How a view's camera differs from the camera of the map. */
struct CameraDifference {
  enum class Mounting {
    same,        ///< the floor's information about the pose holds for both
    other,       ///< both are known, and differ
    unknown,     ///< the map has a mounting, the view's camera has none
    not_in_map,  ///< the map has none
  };
  Mounting mounting = Mounting::not_in_map;
  bool same_optics = true;  ///< the map's distortion, if it has one, holds for the view's camera, too
  bool distortion_is_left_in = false;  ///< it does, and was not taken out of the view
  double noise_ratio = 1;              ///< noise of inverse depth at the usual depth, the view's by the map's

  bool sameMounting() const { return mounting == Mounting::same; }
};

/** \brief Compares the camera of a view with a map's. \param noise_std noise of inverse depth at the usual
 * depth that the view was seen with [1/m]; 0 = as the camera's specification says */
CameraDifference differenceOf(const Camera& of_view, const Camera& of_map, double noise_std = 0);

/** \brief The difference in sentences without full stop, one for each thing that changes an answer; empty for
 * equal cameras. */
std::vector<std::string> toString(const CameraDifference& difference, const Camera& of_view,
                                  const Camera& of_map);

/** \brief "0.980 m above the floor, 10.0 deg down". */
std::string toString(const CameraMounting& mounting);

}  // namespace facetloc
