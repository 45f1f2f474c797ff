// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/mapping/map_session.h>

#include <memory>
#include <string>
#include <vector>

namespace facetloc::internal {

/** \brief An image of a session that has its place in the map. */
struct SessionImage {
  std::string name;
  double stamp = 0;  ///< [s]
  std::shared_ptr<const View> view;
  Eigen::Isometry3d T_w_c = Eigen::Isometry3d::Identity();
  bool confirmed = true;  ///< otherwise it must agree with the map around it almost everywhere to count
};

/** \brief Removes local models from a map, and the links that lead to them. */
void removeModels(const std::vector<char>& removed, Map& map);

/** \brief MapSession::update() with images in their places. The same for any number of threads. */
MapChanges updateMap(Map& map, const std::vector<SessionImage>& session, const MapBuilderParams& builder,
                     const MapSessionParams& params, int threads = 1);

}  // namespace facetloc::internal
