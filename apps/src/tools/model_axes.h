// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/mapping/surface.h>

#include <Eigen/Geometry>

#include <optional>
#include <string>

namespace facetloc {

/** \brief Metres per unit of a model: m, cm, mm, in or ft. Throws UsageError for another word. */
double metresPer(const std::string& unit);

/** \brief "z", "-y", or three numbers; none for "auto". Throws UsageError for anything else. */
std::optional<Eigen::Vector3d> directionOf(const std::string& words);

/** \brief "1,2.5,0". Throws UsageError for anything else. */
Eigen::Vector3d placeOf(const std::string& words);

/** \brief A direction as directionOf() reads it. */
std::string toOption(const Eigen::Vector3d& direction);

/** \brief The upward directions that a model suggests, as options. */
std::string upOptions(const SurfaceOrientation& orientation);

/** \brief The remark about an upward direction that the model contradicts; empty if it does not.
 * \param up a unit vector */
std::string upRemark(const SurfaceOrientation& orientation, const Eigen::Vector3d& up);

/** \brief The remark about a unit that gives rooms impossible heights; empty if it does not.
 * \param unit in which the model was read \param bounds of it [m] */
std::string unitRemark(const std::string& unit, const SurfaceOrientation& orientation,
                       const Eigen::AlignedBox3d& bounds, const Eigen::Vector3d& up);

}  // namespace facetloc
