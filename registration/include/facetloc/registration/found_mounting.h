// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <optional>
#include <string>

namespace facetloc {

/** \brief How a camera is mounted on a robot, by the floor that its images show. */
struct FoundMounting {
  CameraMounting mounting;
  int models = 0;      ///< local models that show the floor so
  int all_models = 0;  ///< of so many

  /** \brief "0.980 m above the floor, 10.0 deg down, by the floor in 140 of 160 local models". */
  std::string inWords() const;
};

/** \brief Looks for a plane below the camera that is the same in most local models although the camera has
 * moved: the floor under a robot. Nothing for a camera in the hand, whose height and tilt spread; for one
 * that is rolled by more than 2 deg; and where the camera has not moved by 2 m, or nobody knows whether it
 * has. \param map of which segments and poses are read */
std::optional<FoundMounting> findMounting(const Map& map);

}  // namespace facetloc
