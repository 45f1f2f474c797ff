// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/depth_sequence.h>
#include <facetloc/mapping/map_making.h>

#include <functional>
#include <optional>

/** \file
 * A recording as a run of MapMaking, and images beside a map: the one way from files to the judge, which
 * Python shares. */

namespace facetloc {

/** \brief How the images of a recording are read for a run. */
struct RunReading {
  int working_width = 320;       ///< [px]; 0 = full size
  double pose_tolerance = 0.02;  ///< maximum time between an image and its pose [s]
  std::function<std::optional<Gravity>(double stamp)> gravity{};  ///< may be empty
};

/** \brief An image of a sequence, for MapMaking and MapSession. The sequence must outlive it. */
MapImage mapImage(const DepthSequence& sequence, std::size_t index, int working_width,
                  const std::optional<Eigen::Isometry3d>& T_w_c = {},
                  const std::optional<Gravity>& gravity = {});

/** \brief Adds all images of a sequence, with the poses at their times, and the poses between them. Sequence
 * and poses, which may be empty, must outlive the run. */
void addImages(const DepthSequence& sequence, const Trajectory& poses, const RunReading& how,
               MapMaking& making);

/** \brief Tests the surfaces of a run's images, then their poses: making.findings(). Each test rests on those
 * before it, and is left out if they refuse the recording.
 * \param read findings of reading the sequence \param in_any_case refusals do not count */
void checkRun(const DepthSequence& sequence, const Findings& read, MapMaking& making,
              bool in_any_case = false);

/** \brief How the camera of images differs from the map's. */
Findings differenceFindings(const Camera& of_images, const Map& map);

}  // namespace facetloc
