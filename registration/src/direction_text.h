// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <cstdio>
#include <string>

namespace facetloc {

/** \brief A direction whose sign means nothing: its largest component is shown positive. */
inline std::string directionText(const Eigen::Vector3d& v) {
  int largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  const Eigen::Vector3d d = v[largest] < 0 ? Eigen::Vector3d(-v) : v;
  char text[64];
  std::snprintf(text, sizeof text, "(%.2f, %.2f, %.2f)", d.x() + 0.0, d.y() + 0.0, d.z() + 0.0);
  return text;
}

}  // namespace facetloc
