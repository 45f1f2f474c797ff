// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/localization/localization_params.h>
#include <facetloc/localization/sure_calibration.h>
#include <facetloc/mapping/map_image.h>

#include <memory>

namespace facetloc {

/** \brief Localizes the view of each local model that has a pose in the map without that model, those
 * within 0.35 m and 10 deg of it and all that densify() has rendered, and adds the answers to a calibration:
 * for maps without another recording. \param threads 0 = all cores. Throws the exceptions of reading the map
 * and of the callback. */
void addOwnViews(const std::shared_ptr<const Map>& map, SureCalibration& calibration,
                 const RightPose& is_right = {}, const GlobalLocalizationParams& params = {}, int threads = 1,
                 const MapProgressCallback& progress = {});

}  // namespace facetloc
