// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief How a camera moved between two images, by the images themselves. */
struct SeenMotion {
  double stamp_a = 0, stamp_b = 0;                          ///< [s]
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< pose of the second camera in the first
};

/** \brief The poses T_w_c of a camera by time [s]; nothing where they are not known. */
using PosesByTime = std::function<std::optional<Eigen::Isometry3d>(double stamp)>;

/** \brief How far motions by poses are from those that images show: medians. */
struct PoseDisagreement {
  double rotation_deg = 0;
  double translation = 0;   ///< [m]
  std::size_t motions = 0;  ///< whose poses are known

  /** \brief "0.78 deg, 18 mm, median of 61 motions". */
  std::string inWords() const;
};

/** \brief What images say of the poses that they are said to have. */
struct PoseCheck {
  PoseDisagreement as_given;
  std::string cause;              ///< what is wrong with the poses, in words, if that explains it; else empty
  PoseDisagreement mended;        ///< without that fault
  bool wrong_convention = false;  ///< of numbers, axes or units, which is more than an inaccuracy

  /** \brief Are there enough motions to judge by? */
  bool isKnown() const;
  /** \brief No map can be made of such poses: they are known, and in a wrong convention, or have nothing to
   * do with the images. */
  bool isBeyondSense() const;
};

/** \brief Compares poses with what images show of the motion between them, and if they disagree, tries what
 * poses suffer from: quaternions in the order w x y z; the inverse; the axes of a robot's body (x forward, z
 * up) or of OpenGL (z backward, y up); another clock; another scale, of the poses or of depth; a wrong
 * focal length. A fault is named if without it the disagreement is less than half as large. \param
 * motions of which some may be wrong */
PoseCheck checkPoses(const std::vector<SeenMotion>& motions, const PosesByTime& poses);

}  // namespace facetloc
