// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/depth_picture.h>
#include <facetloc/features/gravity.h>
#include <facetloc/features/segment.h>

#include <istream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief The depth picture of another image in a view, and the pose of its camera there. */
struct SidePicture {
  std::shared_ptr<const DepthPicture> picture;  ///< never null or empty
  Eigen::Isometry3d T_v_c;                      ///< its camera in the frame of the view
};

/** \brief The content of one depth image: its segments and its small depth picture, in the camera optical
 * frame. Several images make one view by joined(), in the frame of the first.
 */
struct View {
  Intrinsics intrinsics;  ///< intrinsics of the working image
  std::shared_ptr<const Camera>
      camera;  ///< the camera that saw it; null in a map: the map's camera; else an unknown one
  std::vector<Segment> segments;     ///< the most useful first, by information content (METHOD 9)
  DepthPicture depth;                ///< may be empty: dense checks are then skipped
  std::optional<Gravity> gravity{};  ///< when the image was taken, if it was measured
  std::vector<SidePicture> sides{};  ///< pictures of the other images; empty for one image

  bool hasPicture() const { return depth.camera.valid(); }
  /** \brief Noise of inverse depth that it was seen with, at the usual depth [1/m]. */
  double noise() const { return depth.noise.ofInverseDepth(DepthNoise::kUsualDepth); }
};

/** \brief A view of segments alone, without depth. It has their noise, the largest if they differ; \param
 * usual noise of those that do not know theirs */
View viewOfSegments(std::vector<Segment> segments, const DepthNoise& usual = {});

/** \brief A view and where its camera was in the frame of another one. */
struct PosedView {
  std::shared_ptr<const View> view;
  PoseWithCovariance T_v_c;  ///< positive semidefinite covariance; its error is common to the segments
};

/** \brief One view of several images of a moment: the first with the segments and pictures of the others, in
 * the frame of the first (METHOD 12). */
View joined(const View& first, const std::vector<PosedView>& others);

/** \brief A pointer that does not own its object. */
template <class T>
std::shared_ptr<const T> unowned(const T& object) {
  return std::shared_ptr<const T>(std::shared_ptr<const T>(), &object);
}

/** \brief Storage of the views of a map that is too large to be in memory all at once. Thread-safe; all
 * functions throw the exceptions of reading. */
class MapStore {
public:
  virtual ~MapStore() = default;
  /** \brief Its name in error messages: the name of its file. */
  virtual std::string name() const { return "the map"; }
  /** \brief The view of local model number i. */
  virtual std::shared_ptr<const View> view(int i) const = 0;
  /** \brief Whether that view has a depth picture. */
  virtual bool hasPicture(int i) const { return view(i)->hasPicture(); }
  /** \brief The map's PlaceIndex as it was written; null if the map has none. */
  virtual std::unique_ptr<std::istream> placeIndex() const { return nullptr; }
};

/** \brief A local model of the map: the view of one map image, in the frame S_M of its camera. Map::view()
 * reads the view, in memory or in a MapStore. Copies share it. */
struct LocalModel {
  LocalModel() = default;
  LocalModel(std::string name, double stamp, const std::optional<Eigen::Isometry3d>& T_w_m = {});
  LocalModel(std::string name, double stamp, const std::optional<Eigen::Isometry3d>& T_w_m, View view);

  std::string name;
  double stamp = 0;                        ///< [s]
  std::optional<Eigen::Isometry3d> T_w_m;  ///< pose of S_M in the frame of its part of the map, if known
  int part = 0;                            ///< index of the part of the map
  /** \brief Score of the best wrong place for its view [nats], if the map was asked and has one
   * (localization/METHOD 1.5). */
  std::optional<double> alias_score{};
  bool by_links = false;  ///< T_w_m follows from the map's links (placeByLinks()), and was not given

  /** \brief Replaces its view by one in memory. */
  void setView(View view);
  void setView(std::shared_ptr<const View> view) { view_ = std::move(view), store_.reset(); }
  /** \brief Whether its view has a depth picture; false without a view. */
  bool hasPicture() const;
  /** \brief T_w_m as whoever made the map has given it. */
  std::optional<Eigen::Isometry3d> givenPose() const { return by_links ? std::nullopt : T_w_m; }

private:
  friend struct Map;
  std::shared_ptr<const View> view_;       // null if the store has it
  std::shared_ptr<const MapStore> store_;  // ... view number index_ of a store
  int index_ = 0;
};

/** \brief A topological link between two local models. */
struct Link {
  int from = 0;  ///< index of a local model
  int to = 0;
  PoseWithCovariance T_from_to;
};

/** \brief How easily the places of a map are confused: the scores of wrong places when its own views are
 * localized in the map without their surroundings. */
struct MapAmbiguity {
  double score = 0;  ///< mean of the highest tenth [nats]
  int views = 0;     ///< that were asked for, and for which there was another place to be taken for theirs
};

struct Map;

/** \brief One of several maps that are one (joinMaps()). */
struct JoinedMap {
  std::string name;  ///< not empty, without a slash
  std::shared_ptr<const Map> map;
  int first_part = 0;  ///< index of its first part among those of all maps
};

/** \brief A map: local models and links between them.
 *
 * It may consist of parts whose relative poses are unknown. Each has a frame of its own, and
 * poses of different parts cannot be compared. */
struct Map {
  Camera camera;  ///< that its images were taken with; its distortion is taken out of them
  std::vector<LocalModel> models;
  std::vector<Link> links;
  std::vector<std::string> parts;         ///< their names; the world's is empty. None = all is the world
  std::optional<MapAmbiguity> ambiguity;  ///< as far as it was asked about itself
  std::map<std::string, std::string>
      meta;                       ///< how it was made: parameters, software version, conventions in words
  std::vector<JoinedMap> joined;  ///< the maps that joinMaps() has made it of; none for a map of one file

  /** \brief The view of local model number i, wherever it is stored. Throws the exceptions of reading it, and
   * std::logic_error if the model has none. */
  std::shared_ptr<const View> view(int i) const;

  /** \brief Replaces the views of all local models by those of a store, by their index. */
  void setStore(std::shared_ptr<const MapStore> store);
  /** \brief The store that was set last; null for a map in memory. */
  const std::shared_ptr<const MapStore>& store() const { return store_; }

  /** \brief The name of the part that local model number i belongs to; empty for the world. */
  std::string partOf(int i) const;
  /** \brief The joined map that a part belongs to; null if none are joined. */
  const JoinedMap* joinedMap(int part) const;
  /** \brief Likewise; the map itself if none are joined. */
  const Map& mapOf(int part) const { return joined.empty() ? *this : *joinedMap(part)->map; }

  /** \brief A camera whose images are to be localized in the map: with the distortion that the map has found,
   * if its optics are those of the map's camera and nothing else is known. */
  Camera calibrated(Camera of_images) const;

private:
  std::shared_ptr<const MapStore> store_;
};

}  // namespace facetloc
