// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/gravity.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace facetloc {

/** \brief A depth image of a run, not yet read. */
struct MapImage {
  std::string name;  ///< unique within the run
  double stamp = 0;  ///< [s]
  /** Reads it, at the resolution to work at and as its camera has measured it. It is called a few times, by
   * any thread, so that no image need stay in memory. An image for which it throws is left out. */
  std::function<DepthImage()> load;
  std::optional<Eigen::Isometry3d> T_w_c{};  ///< pose of the camera, if it is known
  std::optional<Gravity> gravity{};          ///< measured direction in its optical frame; empty if unknown
  bool timed = true;                         ///< false: the stamp is assumed, and no speed follows from it
};

/** \brief Poses of a camera by time [s]; nothing where they are unknown. */
using PosesByTime = std::function<std::optional<Eigen::Isometry3d>(double stamp)>;

/** \brief Progress of one stage of a longer work. */
struct MapProgress {
  enum class Stage {
    trajectory,  ///< images are followed
    loops,       ///< keyframes are compared, in percent
    poses,       ///< images are compared with their poses
    distortion,  ///< images are read for the distortion of their camera
    viewpoints,  ///< a surface is looked at from where a camera can be
    models,      ///< images become local models
    place,       ///< keyframes are localized in a map
    ambiguity,   ///< views of a map are localized in its other places
    own_views    ///< own images of a map are localized in it without themselves
  };
  Stage stage;
  std::size_t done = 0, total = 0;
};
/** \brief Is called after each item, by one thread at a time. An exception that it throws ends the work once
 * the items begun are done, and is passed on. */
using MapProgressCallback = std::function<void(const MapProgress&)>;

}  // namespace facetloc
