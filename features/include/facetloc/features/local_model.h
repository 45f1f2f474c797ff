// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_picture.h>
#include <facetloc/features/segment.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief What one depth image tells: its segments and its small depth picture, in the camera optical frame.
 */
struct View {
  Intrinsics camera;              ///< of the working image
  std::vector<Segment> segments;  ///< sorted by information content, the most useful first (METHOD 10.1)
  DepthPicture depth;             ///< may be empty: dense checks are then skipped
};

/** \brief A local model of the map: the view of one map image, in the frame S_M of its camera. */
struct LocalModel {
  std::string name;
  double stamp = 0;                        ///< [s]
  std::optional<Eigen::Isometry3d> T_w_m;  ///< pose of S_M in the world; unknown in a purely topological map
  View view;
};

/** \brief A topological link between two local models. */
struct Link {
  int from = 0;  ///< index of a local model
  int to = 0;
  PoseWithCovariance T_from_to;
};

/** \brief A map: local models and links between them. */
struct Map {
  std::optional<CameraMounting> mounting;
  std::vector<LocalModel> models;
  std::vector<Link> links;
  std::map<std::string, std::string>
      meta;  ///< how it was made: parameters, software version, conventions in words
};

}  // namespace facetloc
