// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/answer_state.h>
#include <facetloc/features/local_model.h>
#include <facetloc/features/pose.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/localization/sure_calibration.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/mapping/map_findings.h>
#include <facetloc/mapping/map_image.h>
#include <facetloc/mapping/trajectory_estimation.h>
#include <facetloc/segmentation/view_builder.h>

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief How a later session is found in a map, and when the map changes. */
struct MapSessionParams {
  static constexpr const char* kTitle = "A later session in a map";
  int min_agreeing = 3;
  double changed_share = 0.3;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("min_agreeing", p.min_agreeing, 1, 1000,
          "Minimum number of sure images that agree on the place of a session in the map.", kForUsers);
    visit("changed_share", p.changed_share, 0.0, 1.0,
          "Share of gone depth pixels above which a local model is replaced as a whole.", kForUsers);
  }
};

/** \brief Where something with coordinates of its own is in a map. */
struct SessionPlace {
  std::size_t asked = 0;     ///< images that were looked for in the map
  std::size_t sure = 0;      ///< found keyframes with a sure answer
  std::size_t agreeing = 0;  ///< sure ones that agree on one place
  /// pose of each keyframe in the map; empty unless known to 0.1 m and 2 deg
  std::vector<std::optional<Eigen::Isometry3d>> T_w_k;
  std::vector<bool> confirmed;  ///< for each keyframe: confirmed by its own sure answer, or a given pose

  bool found() const { return agreeing > 0; }
  /** \brief "12 of 80 images are sure, 9 of them agree". */
  std::string toString() const;
};

/** \brief A surface of the map that is gone, or one that has come. Coordinates are of the part of the map. */
struct SurfaceChange {
  enum class Kind { removed, added } kind = Kind::removed;
  double area = 0;         ///< [m^2]
  double probability = 0;  ///< METHOD 1.6
  std::size_t looks = 0;   ///< images of the session, or local models for a new surface, that tell
  int part = 0;            ///< index of the part of the map
  std::string seen_by;     ///< local model, or image of the session, that shows most of it
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< towards the cameras that saw it
  std::vector<Eigen::Vector3d> outline;               ///< convex, clockwise as these cameras see it [m]

  const char* name() const { return kind == Kind::removed ? "removed" : "new"; }
};

/** \brief The changes of a map by a session. Local models by their names. */
struct MapChanges {
  struct Replacement {
    std::string old_model, new_model;
  };
  std::vector<std::string> added;
  std::vector<Replacement> replaced;
  std::vector<std::string> retired;  ///< without a view of their place that could replace them
  std::vector<std::string> edited;   ///< which have lost surfaces, and stay
  std::size_t seen = 0;              ///< local models that the session has seen again
  std::size_t surfaces = 0;          ///< segments of local models that are gone
  std::size_t of_surfaces = 0;       ///< number of segments that the session has observed

  /** \brief "2 local models added, 1 replaced, 0 retired, 3 without moved surfaces". */
  std::string toString() const;
  bool any() const { return !(added.empty() && replaced.empty() && retired.empty() && edited.empty()); }
};

/** \brief Notes a session in the meta data of a map, as "session 2" and so on. \param words its origin and
 * its changes */
void noteSession(const std::string& words, Map& map);

/** \brief How a later session is taken up into a map. */
struct MapUpdateParams {
  MapSessionParams session;
  MapBuilderParams places;   ///< which images become local models, and how accurate given poses are
  MappingParams trajectory;  ///< estimation of poses in a session without them
  ViewParams view;           ///< making of views from images
};

/** \brief A later session in a map: finds it there, and brings the map up to date.
 *
 *     facetloc::MapSession session(map, map->calibrated(camera));
 *     for (...) session.add({name, stamp, [=] { return read(file); }, T_w_c});
 *     facetloc::Map changed = *map;
 *     if (session.find().found()) session.update(changed);
 *
 * Its images may have poses, in whatever coordinates, and keep their arrangement then; otherwise their
 * trajectory is found from the images themselves. Same images, same result, for any number of threads. */
class MapSession {
public:
  /** \brief Throws std::invalid_argument for a parameter out of its range. \param camera of the session */
  MapSession(std::shared_ptr<const Map> map, const Camera& camera, const MapUpdateParams& params = {});
  MapSession(MapSession&&) noexcept;
  MapSession& operator=(MapSession&&) noexcept;
  ~MapSession();

  /** \brief Threads; 1 by default, 0 = all cores. */
  void setNumberOfThreads(int n);
  void setProgress(MapProgressCallback progress);
  /** \brief Poses that drift, for a session without other poses, in the axes of its camera. */
  void setOdometry(PosesByTime odometry);
  /** \brief The next image of the session. If any image has a pose, those without one are left out. */
  void add(MapImage image);

  /** \brief The images of the session, with a pose relative to each other: findings().trajectory. Done by
   * find() unless it was done before. */
  void findTrajectory();
  /** \brief Finds the session in the map. */
  const SessionPlace& find();
  const MapFindings& findings() const;
  /** \brief The keyframes whose place in the map is known, as images of the session. */
  std::size_t placed() const;
  /** \brief The images whose place in the map is known, with their poses there. */
  std::vector<TrajectoryPose> poses() const;

  /** \brief The changes since the map was made, where the session has looked: surfaces of the map that
   * several images look through, the largest first, then new ones where several local models look through.
   * The removed ones are those that update() retires. */
  std::vector<SurfaceChange> changes() const;
  /** \brief Brings a map up to date: surfaces that several images of the session have looked through retire,
   * local models that have lost much are replaced, and places that no local model shows become new ones
   * (METHOD 1.6). Its ambiguity is unknown afterwards if anything has changed.
   * \param map a copy of the session's, with its views in memory (readMap()) */
  MapChanges update(Map& map) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** \brief Where a map is in the maps before it. */
struct MapAlignment {
  /// Maps that it was looked for in, and the result; the last one has found it, if any has. Empty for the
  /// first map, for a map without poses, and where no map before it has poses.
  std::vector<std::pair<std::size_t, SessionPlace>> tried;
  bool moved = false;                                           ///< false where it agrees as it is
  Eigen::Isometry3d T_new_old = Eigen::Isometry3d::Identity();  ///< change of its world

  bool isLost() const { return !tried.empty() && !tried.back().second.found(); }
};

/** \brief Moves the maps behind the first one to where their views are found in the maps before them, so that
 * all share one world; maps that agree as they are stay where they are. Maps without poses are left alone.
 * \param threads 0 = all cores
 * \return an alignment of each map; it ends with the first one that is lost. */
std::vector<MapAlignment> alignMaps(std::vector<Map>& maps, int threads = 1,
                                    const MapProgressCallback& progress = {});

/** \brief One map of several that share a world: models in the order of the maps, links kept, and models
 * without a pose placed by their links. Names that occur more than once, and all keys of meta data, get the
 * name of their map in front; if one lacks surfaces, the merged one does. The camera is the first map's, with
 * the first distortion that any map has, and a mounting if all agree on it. \param names one per map. Throws
 * std::invalid_argument if names of local models still collide. */
Map mergedMap(const std::vector<Map>& maps, const std::vector<std::string>& names);

/** \brief The answer for an image of a map in the map without that image. */
struct OwnView {
  int model = 0;  ///< index of its local model
  AnswerState state = AnswerState::unknown;
  double probability = 0;      ///< probability of the first place; 0 without one
  bool right = false;          ///< the first place is the image's own
  std::optional<double> nees;  ///< squared Mahalanobis distance of a right first pose from the stored one
  std::optional<int> mistaken_for;  ///< index of the local model that found a wrong first place
  std::optional<double> distance;   ///< distance of that place [m]; empty in another part of the map
  std::string free_motions{};       ///< PoseLimits::openMotions(), in rounded axes of its part (METHOD 1.8)
  std::string reason{};             ///< reason of an answer that is not sure; may be empty

  bool isSureAndRight() const { return right && state == AnswerState::sure; }
  bool isAlias() const { return mistaken_for && probability >= 0.5; }  ///< probably another place
  /** \brief The stored pose is in the 95 % ellipsoid of a right first pose. */
  bool isInside() const { return nees && *nees <= chiSquareQuantile(6, 0.95); }
  /** \brief "sure" of its own place, "right" but not sure, "wrong", or "unknown" by its state. */
  const char* verdict() const;
};

/** \brief Localizes the image of each local model that has a pose in the map without that model, those within
 * 0.35 m and 10 deg of it and all that densify() has rendered, which are not asked (METHOD 1.8).
 * \param threads 0 = all cores. Throws the exceptions of reading the map, minProbabilityOf() and the
 * callback. \return answers in the order of the local models */
std::vector<OwnView> localizeOwnViews(const std::shared_ptr<const Map>& map, const RightPose& is_right = {},
                                      const GlobalLocalizationParams& params = {}, int threads = 1,
                                      const MapProgressCallback& progress = {});
/** \brief Adds these answers to a calibration, for maps without another recording. */
void addOwnViews(const std::shared_ptr<const Map>& map, SureCalibration& calibration,
                 const RightPose& is_right = {}, const GlobalLocalizationParams& params = {}, int threads = 1,
                 const MapProgressCallback& progress = {});

}  // namespace facetloc
