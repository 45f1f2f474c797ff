// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief The file of a recording's folders that has poses by its name, and can be read as such: first
 * those of a ground truth, then poses of a camera, then other poses, then trajectories, then the odometry.csv
 * of phones. Private to io. */
std::optional<std::filesystem::path> trajectoryIn(const std::vector<std::filesystem::path>& folders);

}  // namespace facetloc::internal
