// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/colours.h"
#include "drawing/pictures.h"
#include "live/live_mapping.h"
#include "outputs/localization_report.h"

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
  std::string state() const {
    return mapped ? "mapping" : answer ? stateName(answer->tracking) : "segmenting";
  }

  /** \brief Why there is no pose, or no certain one. */
  std::string reason() const {
    if (mapped && !mapped->T_w_c) return "nothing known leads from the rest of the map to this place";
    return answer ? answer->reason : std::string();
  }

  /** \brief The reason, and where to look next; if empty, the progress of the map that is being made. */
  std::string remark() const {
    const std::string why = reason();
    if (answer && answer->next_look) return why + (why.empty() ? "" : "; ") + toString(*answer->next_look);
    return why.empty() && mapped ? mapped->toString() : why;
  }

  /** \brief Its local model and the pose relative to it; null without a place, and where the place is carried
   * on since no local model shows anything of the view. */
  const Hypothesis* match() const {
    const bool is_known =
        answer && answer->tracking != TrackingState::searching && answer->tracking != TrackingState::lost;
    const bool has_match =
        is_known && !answer->hypotheses.empty() && !answer->hypotheses.front().pairs.empty();
    return has_match ? &answer->hypotheses.front() : nullptr;
  }

  /** \brief The world pose, be it certain or not, if there is one. */
  const PoseWithCovariance* pose() const {
    if (mapped) return mapped->T_w_c ? &*mapped->T_w_c : nullptr;
    return answer && answer->T_w_c ? &*answer->T_w_c : nullptr;
  }

  /** \brief Part of the map that the pose is in. */
  int part() const { return answer && answer->T_w_c ? answer->hypotheses.front().part : 0; }
  /** \brief Is the pose one to rely on? */
  bool isLocalized() const {
    if (mapped) return mapped->T_w_c.has_value();
    return answer && answer->state == AnswerState::sure;
  }
};
using LiveResultPtr = std::shared_ptr<const LiveResult>;

inline Colour stateColour(const LiveResult& result) {
  constexpr Colour kNoMap = {90, 90, 90}, kMapping = {0, 115, 125}, kNoPlace = {185, 100, 0};
  if (result.mapped) return result.isLocalized() ? kMapping : kNoPlace;
  if (!result.answer) return kNoMap;
  constexpr Colour kTracking[] = {
      {110, 90, 160}, {20, 100, 180}, {20, 130, 60}, {185, 100, 0}, {190, 35, 35}};
  return kTracking[static_cast<int>(result.answer->tracking)];
}

}  // namespace facetloc
