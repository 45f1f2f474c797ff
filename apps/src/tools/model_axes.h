// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/finding.h>
#include <facetloc/mapping/surface.h>

#include <Eigen/Geometry>

#include <filesystem>
#include <optional>
#include <string>

namespace facetloc {

/** \brief Metres per unit of a model: m, cm, mm, in or ft. Throws UsageError for another word. */
double metresPer(const std::string& unit);

/** \brief "z", "-y", or three numbers; none for "auto". Throws UsageError for anything else. */
std::optional<Eigen::Vector3d> directionOf(const std::string& words);

/** \brief The upward direction by the convention of a model's kind: y in an .obj file, z in all others. */
Eigen::Vector3d usualUp(const std::filesystem::path& model);

/** \brief "1,2.5,0". Throws UsageError for anything else. */
Eigen::Vector3d placeOf(const std::string& words);

/** \brief A direction as directionOf() reads it. */
std::string toOption(const Eigen::Vector3d& direction);

/** \brief The upward directions that a model suggests, as options. */
std::string upOptions(const SurfaceOrientation& orientation);

/** \brief The remark about an upward direction that the model contradicts; empty if it does not.
 * \param up a unit vector */
std::string upRemark(const SurfaceOrientation& orientation, const Eigen::Vector3d& up);

/** \brief The finding about a unit that gives rooms unusual heights, a refusal if no building has such; empty
 * if it does not. \param unit in which the model was read \param bounds of it [m] */
std::optional<Finding> unitFinding(const std::string& unit, const SurfaceOrientation& orientation,
                                   const Eigen::AlignedBox3d& bounds, const Eigen::Vector3d& up);

/** \brief The finding about more places for a camera than are looked from. \param spacing of views [m]
 * \param is_plan whether the model is a floor plan, which has no unit to name */
Finding sizeFinding(std::size_t places, double spacing, bool is_plan);

}  // namespace facetloc
