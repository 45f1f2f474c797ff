// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/simulation/simulated_place.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief A clothed person on the floor: head, trunk, arms and legs, some with a coat, some in dark clothes.
 * \param T_w_p where they stand (x forward, z up, origin on the floor)
 * \param stride angle of the legs [rad], 0 = standing
 * \param looks size and clothes are drawn from it */
std::vector<RoundBody> simulatedPerson(const Eigen::Isometry3d& T_w_p, double stride, std::uint64_t looks);

/** \brief People around a camera on its way. In turn, one walks ahead of it and turns round now and then, one
 * walks past, again and again, and one stands around, turns on the spot, and stands elsewhere later. They
 * keep 0.8 m from the camera and are not behind walls. The same arguments, the same people. */
class SimulatedPeople {
public:
  /** \param T_w_c the way of the camera, one pose for each stamp [s] in ascending order */
  SimulatedPeople(int people, std::vector<Eigen::Isometry3d> T_w_c, std::vector<double> stamps,
                  std::uint64_t seed);

  /** \brief The world with the people who are there at image i. */
  SimulatedWorld in(const SimulatedWorld& world, std::size_t i) const;

private:
  /** Where the camera is at a time, upright on the floor, x forward. */
  Eigen::Isometry3d floorPose(double stamp) const;

  int people_;
  std::vector<Eigen::Isometry3d> T_w_c_;
  std::vector<double> stamps_;
  std::uint64_t seed_;
};

}  // namespace facetloc
