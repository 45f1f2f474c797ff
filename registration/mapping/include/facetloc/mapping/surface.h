// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <Eigen/Geometry>

namespace facetloc {

/** \brief Surface of a building that depth images can be rendered of: a mesh, a cloud, fused depth images. */
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

  /** \brief Whether it was drawn, not seen: it holds surfaces that stay, without objects that people move. */
  virtual bool isDrawn() const { return false; }
};

}  // namespace facetloc
