// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/answer_state.h>
#include <facetloc/features/camera.h>
#include <facetloc/features/pose.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A pair (scene segment, model segment) that may be the same surface. */
struct SegmentPair {
  int scene = 0;
  int model = 0;
  double distance = 0;  ///< squared Mahalanobis distance of the planes
};

/** \brief How much of the view a place explains, regardless of other places. Shares from 0 to 1. */
struct Coverage {
  double compared = 0;  ///< pixels of the view where local models near the place have depth
  double agreeing = 0;  ///< compared pixels that agree
  double contradicted =
      0;  ///< compared pixels that contradict: the model saw through the surfaces of the view
  double looked_through = 0;  ///< pixels of those local models within the view that it looks through
  double paired = 0;          ///< support of the view's segments that have a partner
};

/** \brief A pose of the scene camera relative to a local model, with its evidence. */
struct Hypothesis {
  int model = 0;                           ///< index of the local model
  PoseWithCovariance T_m_c;                ///< camera pose in the local model, with covariance
  std::optional<Eigen::Isometry3d> T_w_c;  ///< pose in the frame of the part, if the model's pose is known
  int part = 0;                            ///< part of the map to which the local model belongs
  std::vector<SegmentPair> pairs;          ///< pairs used in the estimate
  std::vector<int> supporting_models;      ///< local models with a hypothesis of this place, once merged
  bool depth_assisted = false;             ///< one translation comes from dense depth, not from planes
  double consensus = 0;                    ///< sum of the segments' log likelihood ratios; or METHOD 10.5
  double free_space = 0;                   ///< log likelihood of its own local model's depth [nats]
  double evidence = 0;     ///< depth evidence of nearby local models [nats]; replaces free_space
  double score = 0;        ///< the list is sorted by it
  Coverage coverage;       ///< shares of the view, with evidence of local models
  double probability = 0;  ///< probability of this place; 0 for a near-duplicate of a better pose
};

/** \brief The answer of localization or registration: a ranked list, how far it can be relied on, and why not
 * farther. */
struct Localization {
  AnswerState state = AnswerState::unknown;
  /** \brief Most probable first, with poses of this view in the frames of their parts of the map. */
  std::vector<Hypothesis> hypotheses;
  /** \brief Probability that the map lacks the place: 1 minus those of all hypotheses. Empty with
   * score.by_overlap, whose scores have no probabilities. */
  std::optional<double> not_in_map = 1;
  std::optional<ViewShares>
      shares;                     ///< shares of a Localizer, at the first place; empty where no depth tells
  std::string reason;             ///< why it is not sure; empty if it is
  bool searched = false;          ///< the whole map, which takes its time
  CameraDifference camera;        ///< how the view's camera differs from the map's
  bool has_probabilities = true;  ///< false if scores are overlaps, whose probabilities mean nothing
  bool fixes_pose = true;         ///< the covariance of the first pose is within PoseLimits
  std::optional<NextLook> next_look;  ///< where to look next, once Localizer::nextLook() has been asked

  /** \name Of a moving camera. */
  /// @{
  TrackingState tracking = TrackingState::searching;
  /** \brief The pose of the first hypothesis in the frame of its part, with the covariance of a left,
   * decoupled perturbation (pose.h); nothing while searching or lost. */
  std::optional<PoseWithCovariance> T_w_c;
  bool began_anew = false;          ///< all earlier views are forgotten; the reason says why
  int looks = 0;                    ///< informative views since everything began anew
  PoseWithCovariance T_before_now;  ///< how the camera has moved, as far as that is known
  /// @}

  /** \brief The one rule: stateOf() the first hypothesis; unknown without one, at most doubtful without
   * probabilities. */
  AnswerState stateAt(double min_probability) const {
    if (hypotheses.empty()) return AnswerState::unknown;
    if (!not_in_map) return AnswerState::doubtful;
    return stateOf(hypotheses.front().probability, fixes_pose, *not_in_map, min_probability);
  }
  /** \brief Sets not_in_map by the probabilities of the hypotheses, and the state. */
  void decide(double min_probability = kMinProbability) {
    double left = 1;
    for (const Hypothesis& h : hypotheses) left -= h.probability;
    not_in_map = has_probabilities ? std::optional(std::max(0.0, left)) : std::nullopt;
    state = stateAt(min_probability);
  }
};

}  // namespace facetloc
