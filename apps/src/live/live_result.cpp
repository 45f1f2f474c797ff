// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_result.h"

namespace facetloc {

std::string LiveResult::state() const {
  return mapped ? "mapping" : answer ? stateName(answer->tracking) : "segmenting";
}

std::string LiveResult::reason() const {
  if (mapped && !mapped->T_w_c) return "nothing known leads from the rest of the map to this place";
  return answer ? answer->reason : std::string();
}

std::string LiveResult::remark() const {
  const std::string why = reason();
  return why.empty() && mapped ? mapped->toString() : why;
}

// Where no local model shows anything of the view, the place is carried on.
const Hypothesis* LiveResult::match() const {
  const bool is_known =
      answer && answer->tracking != TrackingState::searching && answer->tracking != TrackingState::lost;
  const bool has_match = is_known && !answer->hypotheses.empty() && !answer->hypotheses.front().pairs.empty();
  return has_match ? &answer->hypotheses.front() : nullptr;
}

const PoseWithCovariance* LiveResult::pose() const {
  if (mapped) return mapped->T_w_c ? &*mapped->T_w_c : nullptr;
  return answer && answer->T_w_c ? &*answer->T_w_c : nullptr;
}

bool LiveResult::isLocalized() const {
  if (mapped) return mapped->T_w_c.has_value();
  return answer && answer->state == AnswerState::sure;
}

Colour stateColour(const LiveResult& result) {
  constexpr Colour kNoMap = {90, 90, 90}, kMapping = {0, 115, 125}, kNoPlace = {185, 100, 0};
  if (result.mapped) return result.isLocalized() ? kMapping : kNoPlace;
  if (!result.answer) return kNoMap;
  switch (result.answer->tracking) {
  case TrackingState::searching:
    return {110, 90, 160};
  case TrackingState::localized:
    return {20, 100, 180};
  case TrackingState::tracking:
    return {20, 130, 60};
  case TrackingState::degenerate:
    return {185, 100, 0};
  case TrackingState::lost:
    return {190, 35, 35};
  }
  return kNoMap;
}

}  // namespace facetloc
