// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace facetloc {

struct View;

/** \brief What tells a wrong map, camera or scale, of one image; 0 where it is not known. */
struct ViewTraits {
  double noise = 0;  ///< standard deviation of inverse depth, found in the image [1/m]
  double fov = 0;    ///< horizontal field of view [deg]
  double depth = 0;  ///< median [m]

  static ViewTraits of(const View& view);
};

}  // namespace facetloc
