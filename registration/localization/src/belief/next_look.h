// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "nearby/nearby_models.h"
#include "ranking/place_ranking.h"

#include <facetloc/features/local_model.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/registration/hypothesis.h>

#include <memory>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief Chooses where a camera looks next: the motion with the largest expected loss of entropy for its
 * length (METHOD 3.7). Never changes; thread-safe. */
class NextLooks {
public:
  NextLooks(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params);

  /** \brief Localizer::nextLook(). \param looked poses of the views so far in the camera: where these looked,
   * little is new \param min_probability of a sure place */
  std::optional<NextLook> best(const View& view, const Localization& answer,
                               const std::vector<Eigen::Isometry3d>& looked, double min_probability) const;

private:
  struct Place;
  struct Expected;
  class Outlook;
  /** \brief The advice by the places of the answer; nothing if no motion is worthwhile. */
  std::optional<NextLook> byPlaces(const View& view, const Localization& answer,
                                   const std::vector<Eigen::Isometry3d>& looked,
                                   double min_probability) const;
  std::vector<Place> placesOf(const Localization& answer) const;
  Expected expectedAt(int part, const Eigen::Isometry3d& T_w_c, const Intrinsics& camera) const;
  double novelty(const Eigen::Isometry3d& T_now_then, const std::vector<Eigen::Isometry3d>& looked) const;

  std::shared_ptr<const Map> map_;
  PoseLimits limits_;
  SequenceCalibration calibration_;
  PlaceRanking ranking_;
  NearbyModels near_;
};

}  // namespace facetloc::internal
