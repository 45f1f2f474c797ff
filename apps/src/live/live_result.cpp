// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_result.h"

namespace facetloc {

std::string LiveResult::state() const { return tracked ? stateName(tracked->state) : "segmenting"; }

bool LiveResult::isLocalized() const {
  return tracked && (tracked->state == TrackingState::localized || tracked->state == TrackingState::tracking);
}

Colour stateColour(const LiveResult& result) {
  constexpr Colour kNoMap = {90, 90, 90};
  if (!result.tracked) return kNoMap;
  switch (result.tracked->state) {
  case TrackingState::searching:
    return {110, 90, 160};
  case TrackingState::localized:
    return {20, 100, 180};
  case TrackingState::tracking:
    return {20, 130, 60};
  case TrackingState::cannot_tell:
    return {185, 100, 0};
  case TrackingState::lost:
    return {190, 35, 35};
  }
  return kNoMap;
}

}  // namespace facetloc
