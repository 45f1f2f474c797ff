// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/localization/shortlist_params.h>
#include <facetloc/registration/registration_params.h>

namespace facetloc {

/** \brief Parameters of the search of a whole map. A field is known by its path, such as `ekf.iterations`. */
struct GlobalLocalizationParams : RegistrationParams {
  static constexpr const char* kTitle = "Global localization";
  ShortlistParams shortlist;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("prior", p.prior);
    visit("shortlist", p.shortlist);
    ViewRegistrationParams::describe(p, visit);
    describeRanking(p, visit);
  }
  /** \brief Throws std::invalid_argument for a parameter or a constant out of its range. */
  void validate() const { checkRanges(*this), calibration.validate(); }
};

}  // namespace facetloc
