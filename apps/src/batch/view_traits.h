// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace facetloc {

struct View;

/** \brief Statistics of one image that reveal a wrong map, camera or scale; 0 if unknown. */
struct ViewTraits {
  double noise = 0;  ///< standard deviation of inverse depth, found in the image [1/m]
  double fov = 0;    ///< horizontal field of view [deg]
  double depth = 0;  ///< median [m]

  static ViewTraits of(const View& view);
};

}  // namespace facetloc
