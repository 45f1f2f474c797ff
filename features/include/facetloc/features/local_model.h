// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_distortion.h>
#include <facetloc/features/depth_picture.h>
#include <facetloc/features/segment.h>

#include <istream>
#include <map>
#include <memory>
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

/** \brief A pointer to what somebody else keeps. */
template <class T>
std::shared_ptr<const T> borrowed(const T& object) {
  return std::shared_ptr<const T>(std::shared_ptr<const T>(), &object);
}

/** \brief A local model of the map: the view of one map image, in the frame S_M of its camera. */
struct LocalModel {
  std::string name;
  double stamp = 0;                        ///< [s]
  std::optional<Eigen::Isometry3d> T_w_m;  ///< pose of S_M in the world; unknown in a purely topological map
  View view;

  /** \brief True also where the picture itself is in a MapStore. */
  bool hasPicture() const { return view.depth.camera.valid(); }
};

/** \brief A topological link between two local models. */
struct Link {
  int from = 0;  ///< index of a local model
  int to = 0;
  PoseWithCovariance T_from_to;
};

/** \brief Where the parts of a map are that are too large to be in memory all at once. Thread-safe; all
 * functions throw what reading throws. */
class MapStore {
public:
  virtual ~MapStore() = default;
  /** \brief The view of local model number i. */
  virtual std::shared_ptr<const View> view(int i) const = 0;
  /** \brief The map's PlaceIndex as it was written; null if there is none. */
  virtual std::unique_ptr<std::istream> placeIndex() const = 0;
};

/** \brief A map: local models and links between them. */
struct Map {
  std::optional<CameraMounting> mounting;
  std::optional<DepthDistortion>
      distortion;  ///< of the camera: taken out of the models' images, to be taken out of others
  std::vector<LocalModel> models;
  std::vector<Link> links;
  std::map<std::string, std::string>
      meta;  ///< how it was made: parameters, software version, conventions in words
  std::shared_ptr<const MapStore> store;  ///< if not null, the models' own views tell their cameras alone

  /** \brief The view of local model number i, wherever it is; in the map's memory, valid while the map is. */
  std::shared_ptr<const View> view(int i) const {
    return store ? store->view(i) : borrowed(models[static_cast<std::size_t>(i)].view);
  }
};

}  // namespace facetloc
