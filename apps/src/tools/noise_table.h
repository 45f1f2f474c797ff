// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/image_noise.h>

#include <ostream>
#include <vector>

namespace facetloc {

/** \brief Prints noise over range as a table, and the lines of a camera.ini that say it. Requires one bin. */
void printNoise(std::ostream& out, const std::vector<NoiseBin>& bins);

}  // namespace facetloc
