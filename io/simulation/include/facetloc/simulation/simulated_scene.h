// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief How a surface answers the projector of a depth camera. */
enum class Material : std::uint8_t {
  matt,
  dark,  ///< reflects so little that patches of it are lost, more of them far away and at grazing angles
  glass  ///< is seen only in patches; most rays go on to the surface behind
};

/** \brief A one-coloured rectangle of the simulated world: centre, two unit axes and half sizes [m]; seen
 * from both sides. Rectangles of the same plane id are one plane in the true labels. */
struct Rectangle {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_u = Eigen::Vector3d::UnitX();
  Eigen::Vector3d axis_v = Eigen::Vector3d::UnitY();
  double half_u = 1;
  double half_v = 1;
  std::uint16_t plane_id = 1;
  Material material = Material::matt;

  Eigen::Vector3d normal() const { return axis_u.cross(axis_v); }
};

/** \brief A curved thing, which is no plane and has the label 0: an ellipsoid, or an upright cylinder
 * (open at its ends), in its own frame, with half sizes along its axes [m]. */
struct RoundBody {
  enum class Shape : std::uint8_t { ellipsoid, cylinder };
  Shape shape = Shape::ellipsoid;
  Eigen::Isometry3d T_w_b = Eigen::Isometry3d::Identity();
  Eigen::Vector3d half_size = Eigen::Vector3d::Ones();
  Material material = Material::matt;
};

/** \brief How far surfaces are from where a scene says: each is moved along its normal by a smooth function
 * of the place on it, another one for each plane id. */
struct SurfaceBending {
  double std = 0;          ///< standard deviation of the displacement [m]; 0 = surfaces without errors
  double length = 2;       ///< shortest wavelength [m]; the longest is three times that
  std::uint64_t seed = 1;  ///< the same seed, the same surfaces
};

/** \brief The surfaces that a simulated camera can see; z up, floor at z = 0. */
struct Scene {
  std::vector<Rectangle> rectangles;
  std::vector<RoundBody> bodies;
  SurfaceBending bending{};
};

/** \brief Adds the six faces of a box (centre, orientation, half sizes); plane ids count up from next_id. */
void addBox(Scene& scene, const Eigen::Isometry3d& T_w_box, const Eigen::Vector3d& half_size,
            std::uint16_t& next_id);
/** \brief A closed room of random size with random boxes on its floor and walls, z up, floor at z = 0. The
 * middle, within 0.8 m of the z axis, is free for a camera. Same seed, same room. */
Scene randomRoom(std::uint64_t seed, int boxes = 8);

}  // namespace facetloc
