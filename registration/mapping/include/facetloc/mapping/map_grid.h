// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/occupancy_grid.h>
#include <facetloc/features/params.h>

namespace facetloc {

/** \brief Limits of obstacles for a 2-D robot. */
struct MapGridParams {
  static constexpr const char* kTitle = "Occupancy grid of a map";
  double resolution = 0.05;
  double lowest = 0.2;
  double highest = 1.8;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("resolution", p.resolution, 0.005, 1.0, "Side of a cell [m].", kForUsers);
    visit("lowest", p.lowest, 0.0, 100.0, "Minimum height of obstacles above the floor [m].", kForUsers);
    visit("highest", p.highest, 0.0, 100.0, "Maximum height of obstacles above the floor [m].", kForUsers);
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Occupancy grid of a map, or of its largest part, in the axes of its world, whose z axis is up.
 *
 * A cell is occupied where depth pictures show points of upright segments within the band of heights, free
 * where only rays pass within the band, at any height, unknown otherwise. Where both were seen, most views
 * decide. The floor
 * is where the mounting of the map's camera puts it, or the lowest of the large level segments. Throws
 * std::runtime_error with a sentence for a map that has no poses, no depth pictures, no floor or more than 64
 * million cells, and std::invalid_argument for a parameter out of its range. */
OccupancyGrid gridOf(const Map& map, const MapGridParams& params = {});

}  // namespace facetloc
