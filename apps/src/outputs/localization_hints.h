// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "batch/bytes.h"
#include "outputs/localization_report.h"

#include <facetloc/features/local_model.h>

#include <string>
#include <vector>

namespace facetloc {

/** \brief The median of values that are known; 0 without any. */
double medianOfKnown(std::vector<double> values);

/** \brief If hardly any answer is sure, things to check: sentences that begin with the likeliest cause. Else
 * empty. \param views of the images, as far as they are known */
std::vector<std::string> whatToLookAt(const StateCounts& counts, const std::vector<ViewTraits>& views,
                                      const Map& map);

}  // namespace facetloc
