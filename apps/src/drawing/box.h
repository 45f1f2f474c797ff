// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace facetloc {

/** \brief A rectangle of a page, from its top left corner [px]. */
struct Box {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;

  double right() const { return left + width; }
  double bottom() const { return top + height; }
  Eigen::Vector2d centre() const { return {left + width / 2, top + height / 2}; }
};

}  // namespace facetloc
