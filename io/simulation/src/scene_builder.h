// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "random.h"

#include <facetloc/simulation/simulated_place.h>

#include <vector>

namespace facetloc {

/** \brief When a thing stands where it stands. */
enum class When { always, mapped, later };

/** \brief A thing on the floor: its place and heading. */
struct Spot {
  Eigen::Vector2d place;
  double yaw = 0;  ///< [rad]
  double z = 0;    ///< height of its foot [m]

  Eigen::Isometry3d pose() const;
  /** \brief A spot given in the frame of this one. */
  Spot relative(double x, double y, double turn = 0, double up = 0) const;
};

/** \brief A hole in a wall. */
struct Opening {
  double at = 0;  ///< its middle, along the wall from its start [m]
  double width = 0.9;
  double bottom = 0;  ///< above the floor [m]
  double top = 2.05;
  bool glazed = false;  ///< a pane in the middle of the wall's thickness
};

/** \brief Puts a simulated place together: every function adds to the world that is mapped, to the later one,
 * or to both, and numbers the planes. z is up, the floor is at z = 0, lengths are in metres. */
class SceneBuilder {
public:
  explicit SceneBuilder(SimulatedPlace& place) : place_(place) {}

  /** \brief A rectangle standing alone, with a new plane id, or with a given one if it continues a plane. */
  std::uint16_t rectangle(const Eigen::Vector3d& centre, const Eigen::Vector3d& half_u,
                          const Eigen::Vector3d& half_v, When when = When::always,
                          Material material = Material::matt, std::uint16_t id = 0);
  /** \brief A box on its spot: size along x, y, z of the spot. Its foot is not seen and left out if it
   * stands on the floor. */
  void box(const Spot& spot, const Eigen::Vector3d& size, When when = When::always,
           Material material = Material::matt);
  /** \brief A box anywhere, given by its middle; all its faces. */
  void box(const Eigen::Isometry3d& T_w_box, const Eigen::Vector3d& size, When when, Material material);
  /** \brief An upright cylinder with a flat lid. */
  void cylinder(const Spot& spot, double radius, double height, When when = When::always,
                Material material = Material::matt);
  void ellipsoid(const Spot& spot, double centre_z, const Eigen::Vector3d& half_size,
                 When when = When::always, Material material = Material::matt);
  /** \brief A straight wall between two points of the floor plan, with a thickness to both sides of the
   * line: its faces (one plane each), and the reveals, lintels and sills of its openings. */
  void wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness, double height,
            const std::vector<Opening>& openings = {});
  /** \brief A box, or a cylinder, that belongs to the building. */
  void pillar(const Spot& spot, const Eigen::Vector3d& size);
  void roundPillar(const Spot& spot, double radius, double height);
  /** \brief A door leaf, hinged at a point, its far edge in a direction [rad]. */
  void doorLeaf(const Eigen::Vector2d& hinge, double direction, double width, double height,
                When when = When::always);
  /** \brief A level rectangle, such as floor or ceiling. */
  void level(const Eigen::AlignedBox2d& area, double z);

private:
  void add(const Rectangle& rectangle, When when);
  void add(const RoundBody& body, When when);
  void addFaces(const Eigen::Isometry3d& T_w_box, const Eigen::Vector3d& size, When when, Material material,
                bool with_foot);

  SimulatedPlace& place_;
  std::uint16_t next_id_ = 1;
};

// ---- Places: most have a file each, such as office_floor.cpp ----
SimulatedPlace officeFloor(std::uint64_t seed);
SimulatedPlace homeFloor(std::uint64_t seed);
SimulatedPlace hallFloor(std::uint64_t seed);
SimulatedPlace bareCorridor(std::uint64_t seed);
SimulatedPlace equalRooms(std::uint64_t seed);
SimulatedPlace bareFloor(std::uint64_t seed);
SimulatedPlace equalDoors(std::uint64_t seed, int n_doors);  // on each side
SimulatedPlace symmetricBox(std::uint64_t seed);

}  // namespace facetloc
