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
  int all_models = 0;  ///< number of models examined

  /** \brief "0.980 m above the floor, 10.0 deg down, by the floor in 140 of 160 local models". */
  std::string toString() const;
};

/** \brief The floor as a camera sees it. */
struct SeenFloor {
  double height = 0;      ///< mean height of the camera above it [m]
  double tilt_deg = 0;    ///< tilt of the optical axis below the horizon
  double roll_deg = 0;    ///< about the optical axis: positive if the camera's right side is lower
  double height_std = 0;  ///< over the views [m]
  int views = 0;          ///< that show it so
  int all_views = 0;      ///< number of views examined
  bool steady = false;    ///< as under a robot; the floor below a camera in the hand comes and goes

  /** \brief The mounting of a robot's camera that sees it so. A roll of less than 2 deg counts as none. */
  CameraMounting mounting() const;
};

/** \brief Looks for the plane below the camera that most local models have in common. Nothing if fewer than
 * 10, or than 30 %, show one. \param map of which segments are read */
std::optional<SeenFloor> findFloor(const Map& map);

/** \brief The mounting found by the floor, where it is the same in most local models although the camera
 * has moved. Nothing for a camera in the hand, whose height and tilt spread, and where the camera has not
 * moved by 2 m, or may not have. A roll of less than 2 deg counts as none. \param map of which
 * segments and poses are read */
std::optional<FoundMounting> findMounting(const Map& map);

}  // namespace facetloc
