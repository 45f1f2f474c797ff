// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string_view>
#include <utility>

namespace facetloc {

/** \brief How far an answer can be relied on. One rule for all tools and classes. */
enum class AnswerState {
  sure,      ///< the first pose is so probable that one may act on it
  doubtful,  ///< there are poses, but none that one may act on
  unknown    ///< no pose, or the map more likely lacks the place than holds it; there is a reason
};

/** \brief Probability from which on an answer is sure, unless the user chooses another. */
constexpr double kMinProbability = 0.9;

/** \brief The one rule for the state of an answer: sure if the best place is probable enough and its
 * covariance fixes the pose (PoseLimits).
 * \param not_in_map probability that the map lacks the place: 1 minus those of all poses
 * \param min_probability of a sure pose */
constexpr AnswerState stateOf(double best, bool fixes_pose, double not_in_map, double min_probability) {
  if (fixes_pose && best >= min_probability) return AnswerState::sure;
  return not_in_map > 0.5 ? AnswerState::unknown : AnswerState::doubtful;
}
constexpr const char* kNotInMap = "the map more likely lacks this place than holds it";

/** \brief "sure", "doubtful", "unknown". */
constexpr const char* toString(AnswerState state) {
  constexpr const char* kNames[] = {"sure", "doubtful", "unknown"};
  return kNames[static_cast<int>(state)];
}

/** \brief The motion that most likely makes an answer sure: a turn on the spot, then straight on
 * (localization/METHOD 3.7). */
struct NextLook {
  double yaw = 0;    ///< turn about the vertical axis, to the left if positive [rad], in (-pi, pi]
  double ahead = 0;  ///< distance to drive after the turn [m]
  double gain = 0;   ///< expected loss of entropy over the places and the errors of their poses [nats]
  double sure = 0;   ///< probability that the answer is sure then
};

/** \brief State of a moving camera in its map, for live programs. */
enum class TrackingState {
  searching,   ///< no place has been sure since the start
  localized,   ///< a place has become sure with this view
  tracking,    ///< the place is sure as it was before
  degenerate,  ///< the place is known, but not sure with this view; the reason tells why
  lost         ///< there was a sure place, and no place is likely any more
};

/** \brief "searching", "localized", "tracking", "cannot tell", "lost". */
constexpr const char* stateName(TrackingState state) {
  constexpr const char* kNames[] = {"searching", "localized", "tracking", "cannot tell", "lost"};
  return kNames[static_cast<int>(state)];
}

/** \brief The state of that name; nothing for another word. */
constexpr std::optional<AnswerState> answerStateOf(std::string_view name) {
  for (const AnswerState state : {AnswerState::sure, AnswerState::doubtful, AnswerState::unknown})
    if (name == toString(state)) return state;
  return {};
}

/** \brief The surfaces of a view by its depth, against those of the map at its place: shares of the pixels
 * near enough to be compared, of which the first three sum to 1, and a share of the map. */
struct ViewShares {
  double explained = 0;  ///< pixels on surfaces of the map
  double hiding = 0;     ///< pixels in front of surfaces of the map, which they hide
  double fresh = 0;      ///< all others, where the map has seen nothing
  double missing = 0;    ///< pixels of the local models, within the view, that it looks through

  /** \brief Each share with its name in files, the stream, pages and Python. */
  static constexpr std::pair<const char*, double ViewShares::*> kNamed[] = {
      {"explained", &ViewShares::explained},
      {"hiding", &ViewShares::hiding},
      {"new", &ViewShares::fresh},
      {"missing", &ViewShares::missing}};
};

}  // namespace facetloc
