// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/colours.h"
#include "drawing/pictures.h"
#include "live/live_mapping.h"
#include "live/live_trajectory.h"

#include <facetloc/localization/localizer.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace facetloc {

/** \brief One processed frame of a live run: the data that are drawn and written. */
struct LiveResult {
  std::uint64_t number = 0;            ///< counts processed frames, from 1
  double stamp = 0;                    ///< [s]; increases from frame to frame
  SeenImage image;                     ///< at the working size; its name is the stamp
  std::optional<Localization> answer;  ///< nothing if there is no map
  std::optional<LiveMapState> mapped;  ///< if a map is being made
  LiveTrajectory trajectory;           ///< where the camera was in the world so far
  bool has_odometry = false;           ///< that has measured how the camera moved since the frame before

  double segment_ms = 0, features_ms = 0, localize_ms = 0;
  double age_ms = 0;           ///< time between the frame's arrival and the begin of its processing
  std::uint64_t received = 0;  ///< frames of the source so far
  std::uint64_t dropped = 0;   ///< received frames that were not processed

  /** \brief "tracking", "cannot tell", ...; "mapping"; "segmenting" without a map. */
  std::string state() const;
  /** \brief Why there is no pose, or no certain one. */
  std::string reason() const;
  /** \brief The reason; if empty, the progress of the map that is being made. */
  std::string remark() const;
  /** \brief Its local model and the pose relative to it, if there is one. */
  const Hypothesis* match() const;
  /** \brief The world pose, be it certain or not, if there is one. */
  const PoseWithCovariance* pose() const;
  /** \brief Part of the map that the pose is in. */
  int part() const { return answer && answer->T_w_c ? answer->hypotheses.front().part : 0; }
  /** \brief Is the pose one to rely on? */
  bool isLocalized() const;
};
using LiveResultPtr = std::shared_ptr<const LiveResult>;

Colour stateColour(const LiveResult& result);

}  // namespace facetloc
