// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "live/live_plan.h"
#include "live/live_result.h"

#include <string>

namespace facetloc {

/** \brief Where the camera is and how exactly, or the segments that it sees, on one line. \param map, plan
 * may be null \param matched segments of the view that the local model has */
std::string poseText(const LiveResult& result, const Map* map, const LivePlan* plan, std::size_t matched);

/** \brief A segment of the view: its number, size, distance, and how exactly its plane is known. */
std::string segmentText(const View& view, std::size_t k);

/** \brief A local model of a map. */
std::string modelText(const Map& map, int i);

}  // namespace facetloc
