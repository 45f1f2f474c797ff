// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/mapping/surface.h>

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace facetloc {

/** \brief A direction along which a surface has levels, such as floors and ceilings, or parallel walls. */
struct SurfaceAxis {
  Eigen::Vector3d direction;  ///< unit vector, in the frame of the surface
  /** Largest plane across the direction, as a share of the surface visible from inside. */
  double support = 0;
  /** 1 if the direction is upwards, -1 if it is downwards, 0 if nothing tells. */
  int upwards = 0;
  /** Median free distance along the direction [m]; 0 where it has no end in half of the surface. */
  double clear_height = 0;
};

/** \brief The upward direction of a surface and the height of its rooms, as visible from inside.
 *
 * Floors and ceilings are larger planes than walls. Furniture stands on floors: more of its surfaces face
 * upwards, and scans lack ceilings rather than floors (METHOD 18.4). */
struct SurfaceOrientation {
  std::vector<SurfaceAxis> axes;  ///< the best supported first; empty if the surface has no planes

  /** \brief The directions that may be upwards, the best supported first: of each axis that none is supported
   * much better than, the upward one. Of an axis whose two directions nothing distinguishes, the one nearer
   * to the frame's z, then y axis. */
  std::vector<Eigen::Vector3d> candidates() const;
  /** \brief The upward direction; empty unless there is exactly one candidate. */
  std::optional<Eigen::Vector3d> up() const;
  /** \brief Does the surface distinguish up() from its opposite? */
  bool isSignKnown() const { return !axes.empty() && axes.front().upwards != 0; }

  /** \brief The evidence of the surface about a supposed upward direction. */
  enum class Verdict {
    plausible,    ///< or unknown
    inclined,     ///< floors are level only in a direction 2 to 15 deg from it
    upside_down,  ///< the opposite is upwards
    other_axis    ///< another axis is supported much better
  };
  struct Judgement {
    Verdict verdict = Verdict::plausible;
    Eigen::Vector3d better;   ///< the upward direction instead; the supposed one if it is plausible
    double clear_height = 0;  ///< along the better one; 0 if unknown
  };
  /** \param up unit vector */
  Judgement judge(const Eigen::Vector3d& up) const;
};

/** \brief Looks around from places inside the bounds of a surface. Same result for any number of threads.
 * \param threads 0 = all cores */
SurfaceOrientation orientationOf(const Surface& surface, int threads = 1);

}  // namespace facetloc
