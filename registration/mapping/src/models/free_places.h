// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/mapping/surface.h>

#include <functional>
#include <vector>

namespace facetloc::internal {

/** \brief Rays and looks around in a surface, in a frame with z up. Thread-safe. */
class SpaceProbe {
public:
  explicit SpaceProbe(const Surface& surface, const Eigen::Isometry3d& T_w_up = Eigen::Isometry3d::Identity())
      : surface_(surface), T_w_up_(T_w_up) {}

  /** \brief Distance to the surface along a unit vector [m]; infinite where nothing is met. */
  double along(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const;
  /** \brief Heights of all surfaces on a vertical line below a point, the highest first [m]. */
  std::vector<double> heightsBelow(Eigen::Vector3d from, double lowest) const;
  /** \brief All around a position: calls a function with the pose T_up_c and the image of each face of a cube
   * of side x side pixels. */
  void look(const Eigen::Vector3d& position, int side,
            const std::function<void(const Eigen::Isometry3d& T_up_c, const DepthImage& face)>& take) const;
  /** \brief Whether the surface knows of nothing else than its shape that keeps a camera away. */
  bool isFree(const Eigen::Vector3d& position) const { return surface_.isFree(T_w_up_ * position); }
  /** \brief Bounds of the surface in the frame with z up. */
  Eigen::AlignedBox3d bounds() const;

private:
  const Surface& surface_;
  Eigen::Isometry3d T_w_up_;
};

/** \brief Levels that something can stand on [m], the lowest first: horizontal surfaces that many of the
 * columns show with room above, but those of furniture.
 * \param columns heights of the surfaces of each, the highest first */
std::vector<double> floorLevels(const std::vector<std::vector<double>>& columns, double standing_room);

/** \brief Where a camera may be. */
struct PlaceRules {
  double step = 0.5;                    ///< spacing of the grid of positions [m]
  double clearance = 0.25;              ///< to all surfaces [m]
  std::vector<double> heights;          ///< above the floor [m]
  bool stands = false;                  ///< on the floor, as a robot does: not above furniture
  std::vector<Eigen::Vector3d> inside;  ///< places of the areas to fill; none = those that are indoors
  /** Distance by which places may lie beside a surface that is open, such as a scan of one side of a room, of
   * which neither the floor below nor walls all around are asked for [m]; 0 = the surface is a whole room. */
  double beside = 0;
  std::size_t most = 0;  ///< positions, more of which are not looked for; 0 = any number
};

/** \brief Possible positions of a camera, and the number left out. */
struct FreePlaces {
  std::vector<Eigen::Vector3d> positions;
  std::size_t outdoors = 0;  ///< positions of areas around all others
  std::size_t too_many = 0;  ///< estimated number of positions, if it is too large: there are none then
};

/** \brief Calls a function with 0 ... n - 1. */
using ForEach = std::function<void(std::size_t n, const std::function<void(std::size_t)>&)>;

/** \brief Positions in a grid, unless there are too many, from which the surroundings are known, that are
 * free, above a floor, and connected to at least 2 m^2 of such positions: indoors, in rooms and not in
 * furniture (METHOD 3.2). */
FreePlaces freePlaces(const SpaceProbe& probe, const PlaceRules& rules, const ForEach& forEach);

}  // namespace facetloc::internal
