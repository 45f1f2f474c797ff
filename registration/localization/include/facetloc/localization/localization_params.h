// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/localization/ranking_params.h>
#include <facetloc/localization/shortlist_params.h>
#include <facetloc/registration/calibration.h>
#include <facetloc/registration/pair_params.h>
#include <facetloc/registration/pose_prior.h>

namespace facetloc {

/** \brief Parameters of the registration of one view with another. */
struct ViewRegistrationParams {
  static constexpr const char* kTitle = "Registration of two views";
  MatchingParams matching;
  EkfParams ekf;
  HypothesisTreeParams tree;
  RegistrationSteps steps;
  ConsensusParams score;
  Calibration calibration;  ///< no group of parameters: replaced as a whole

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("matching", p.matching);
    visit("ekf", p.ekf);
    visit("tree", p.tree);
    visit("steps", p.steps);
    visit("score", p.score);
  }
  /** \brief Throws std::invalid_argument for a parameter or a constant out of its range. */
  void validate() const { checkRanges(*this), calibration.validate(); }
};

/** \brief Parameters of the search of a whole map. A field is known by its path, such as `ekf.iterations`. */
struct GlobalLocalizationParams : ViewRegistrationParams {
  static constexpr const char* kTitle = "Global localization";
  PosePriorParams prior;
  ShortlistParams shortlist;
  EvidenceParams evidence;
  MergingParams merging;
  PlaceRefinementParams refinement;
  ProbabilityParams probability;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("prior", p.prior);
    visit("shortlist", p.shortlist);
    ViewRegistrationParams::describe(p, visit);
    visit("evidence", p.evidence);
    visit("merging", p.merging);
    visit("refinement", p.refinement);
    visit("probability", p.probability);
  }
  /** \brief Throws std::invalid_argument for a parameter or a constant out of its range. */
  void validate() const { checkRanges(*this), calibration.validate(); }
};

}  // namespace facetloc
