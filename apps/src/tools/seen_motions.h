// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/depth_input.h"

#include <facetloc/mapping/pose_check.h>

#include <vector>

namespace facetloc {

/** \brief How the camera moved at some places of a sequence, by its images alone: pairs of images, of which
 * one is registered with the other and the answer is sure. Images that cannot be read are left out. The same
 * for any number of threads. */
std::vector<SeenMotion> seenMotions(const DepthSequence& sequence, const Camera& camera,
                                    const DepthInput& input, int threads, const Console& console);

}  // namespace facetloc
