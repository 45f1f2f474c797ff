// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace facetloc {

/** \brief How the poses of a recording are written, where it is not as facetloc takes them: of the camera's
 * optical frame (x right, y down, z forward) in the world, quaternions in the order x y z w. */
struct PoseReading {
  enum class Axes {
    optical,  ///< x right, y down, z forward
    base,     ///< pose of the robot, by its mounting if that is known, or else x forward, y left, z up
    opengl,   ///< x right, y up, z backward, as of ARKit and Blender
  };
  bool w_first = false;  ///< quaternions are in the order w x y z
  bool inverse = false;  ///< they are of the world in the camera
  Axes axes = Axes::optical;

  /** \brief "auto", or some of "wxyz", "inverse", "base", "opengl" with commas between them. Throws
   * std::invalid_argument with a sentence for anything else. */
  static PoseReading of(std::string_view words);
  bool isUsual() const { return !w_first && !inverse && axes == Axes::optical; }
};

}  // namespace facetloc
