// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/pictures.h"
#include "evaluation/evaluation.h"

#include <facetloc/io/png.h>

#include <string>
#include <vector>

namespace facetloc {

/** \brief An image that was not localized, or not correctly. */
struct Failure {
  std::string run;  ///< may be empty
  std::string frame;
  std::string what;                 ///< such as "0.83 m and 12.10° off, probability 0.93"
  double probability = 0;           ///< probability of rank 1; 0 without an answer
  std::vector<DrawnMatch> answers;  ///< rank 1, then the true pose in the nearest local model
};

/** \brief The images whose rank 1 is wrong or missing, the most confident of them first. Images taken where
 * the map has nothing fail only by an answer of probability kUnsure or more. \param runs that were
 * evaluated, with the poses of this map's local models. Throws std::runtime_error for an answer in a local
 * model that the map has not. */
std::vector<Failure> findFailures(const Evaluation& evaluation, const std::vector<RunResults>& runs,
                                  const Map& map);

/** \brief Several pictures in one, reduced, two beside each other, each with its title. Needs a display. */
Raster<std::uint8_t> contactSheet(const std::vector<Raster<std::uint8_t>>& pictures,
                                  const std::vector<std::string>& titles);

}  // namespace facetloc
