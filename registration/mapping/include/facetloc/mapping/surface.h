// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace facetloc {

/** \brief Surface of a building that depth images can be rendered of: a mesh, a cloud, a floor plan. */
class Surface {
public:
  virtual ~Surface() = default;

  /** \brief The depth image of an ideal camera. 0 where a ray meets no surface or the surface is unknown; a
   * hole is never filled. Thread-safe.
   * \param camera intrinsics of the image
   * \param T_w_c pose of the optical frame in the frame of the surface */
  virtual DepthImage render(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const = 0;

  /** \brief Bounds of the surface in its frame [m]; empty for an empty surface. */
  virtual Eigen::AlignedBox3d bounds() const = 0;

  /** \brief Whether unknown objects may stand before it, as furniture before the walls of a floor plan: they
   * do not contradict the surface. */
  virtual bool isIncomplete() const { return false; }

  /** \brief Whether a camera may be there, as far as more is known than the surface shows: a floor plan names
   * free places. Positions are in the frame of the surface [m]. */
  virtual bool isFree(const Eigen::Vector3d& /*position*/) const { return true; }

  /** \brief Whether it was drawn, not seen: it holds surfaces that stay, without objects that people move. */
  virtual bool isDrawn() const { return false; }
};

/** \brief A direction along which a surface has levels, such as floors and ceilings, or parallel walls. */
struct SurfaceAxis {
  Eigen::Vector3d direction;  ///< unit vector, in the frame of the surface
  /** Largest plane across the direction, as a share of the surface visible from inside. */
  double support = 0;
  /** 1 if the direction is upwards, -1 if it is downwards, 0 if nothing tells. */
  int upwards = 0;
  /** Median free distance along the direction [m]; 0 where it has no end in half of the surface. */
  double clear_height = 0;
  /** Logarithmic odds of being upright [nats]; only differences between axes count. */
  double evidence = 0;
};

/** \brief The upward direction of a surface and the height of its rooms, as visible from inside.
 *
 * Floors and ceilings are larger planes than most walls, and 2 to 4 m apart. Furniture stands on floors: more
 * of its surfaces face upwards, and scans lack ceilings rather than floors (METHOD 3.4). */
struct SurfaceOrientation {
  std::vector<SurfaceAxis> axes;  ///< the one with most evidence first; empty if the surface has no planes
  /** Upward direction by convention, such as the y axis of an OBJ file: odds of 3, too few to decide alone.
   */
  std::optional<Eigen::Vector3d> usual;

  /** \brief The directions that may be upwards: of each axis against which no other has odds of 4, the upward
   * one. Of an axis whose two directions nothing distinguishes, the one nearer to the frame's z, then y
   * axis. */
  std::vector<Eigen::Vector3d> candidates() const;
  /** \brief The upward direction; empty unless there is exactly one candidate. */
  std::optional<Eigen::Vector3d> up() const;
  /** \brief Does the surface distinguish up() from its opposite? */
  bool isSignKnown() const { return !axes.empty() && best().upwards != 0; }

  /** \brief The evidence of the surface about a supposed upward direction. */
  enum class Verdict {
    plausible,    ///< or unknown
    inclined,     ///< floors are level only in a direction 2 to 15 deg from it
    upside_down,  ///< the opposite is upwards, along the axis with most evidence
    other_axis    ///< another axis has odds of 20
  };
  struct Judgement {
    Verdict verdict = Verdict::plausible;
    Eigen::Vector3d better;   ///< the upward direction instead; the supposed one if it is plausible
    double clear_height = 0;  ///< along the better one; 0 if unknown
  };
  /** \param up unit vector */
  Judgement judge(const Eigen::Vector3d& up) const;

private:
  double evidenceFor(const SurfaceAxis& axis) const;
  const SurfaceAxis& best() const;
};

/** \brief Looks around from places inside the bounds of a surface. Same result for any number of threads.
 * \param threads 0 = all cores */
SurfaceOrientation orientationOf(const Surface& surface, int threads = 1);

}  // namespace facetloc
