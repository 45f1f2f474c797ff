// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/registration/hypothesis.h>

#include <memory>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief Where a camera looks next, as Localizer::nextLook() says: the motion with the largest expected loss
 * of entropy for its length (METHOD 3.7). \param looked poses of the views so far in the camera: where these
 * looked, little is new \param min_probability of a sure place */
std::optional<NextLook> nextLook(const std::shared_ptr<const Map>& map,
                                 const GlobalLocalizationParams& params, const View& view,
                                 const Localization& answer, const std::vector<Eigen::Isometry3d>& looked,
                                 double min_probability);

}  // namespace facetloc::internal
