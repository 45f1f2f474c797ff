// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "live/live_result.h"

#include <facetloc/mapping/map_session.h>

#include <cstddef>
#include <filesystem>

namespace facetloc {

/** \brief Today's images of a run in a map, which bring it up to date when the run has ended: one for each
 * step or turn of the camera, in a folder beside the map, MAP.session.
 *
 * They outlive the run: if it is killed, the next one takes them up (takeUp()). Nothing grows with time
 * alone. */
class LiveExtension {
public:
  static std::filesystem::path folderOf(const std::filesystem::path& map);

  /** \brief Creates the folder. Throws IoError. \param camera of the images at their working size */
  LiveExtension(const std::filesystem::path& map, const Camera& camera);
  /** \brief The next frame. Throws IoError if it cannot be kept. */
  void put(const LiveResult& result);

private:
  const std::filesystem::path folder_;
  const Camera camera_;
  Eigen::Isometry3d T_kept_now_ = Eigen::Isometry3d::Identity();
  std::size_t kept_ = 0;
};

/** \brief Brings a map up to date with the images of a run in it, if there are any, and removes them. Images
 * that are not found in the map leave it as it is and stay, in a folder that is named. Prints the outcome.
 * Throws IoError for a map that cannot be read or written. */
void takeUpSession(const std::filesystem::path& map, const MapUpdateParams& params, int threads,
                   const Console& console);

}  // namespace facetloc
