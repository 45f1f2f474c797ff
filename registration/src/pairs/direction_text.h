// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <charconv>
#include <cmath>
#include <string>

namespace facetloc {

/** \brief A direction whose sign means nothing: its largest component is shown positive. */
inline std::string directionText(const Eigen::Vector3d& v) {
  int largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  const Eigen::Vector3d d = v[largest] < 0 ? Eigen::Vector3d(-v) : v;
  std::string text;
  for (int i = 0; i < 3; ++i) {
    char number[16];
    const double rounded = std::round(100 * d[i]) / 100 + 0.0;  // adding zero makes -0 positive
    const auto end = std::to_chars(number, number + sizeof number, rounded, std::chars_format::fixed, 2).ptr;
    text += (i == 0 ? "(" : ", ") + std::string(number, end);
  }
  return text + ")";
}

}  // namespace facetloc
