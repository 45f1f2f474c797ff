// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/mapping/map_findings.h>
#include <facetloc/mapping/map_image.h>
#include <facetloc/mapping/trajectory_estimation.h>
#include <facetloc/segmentation/view_builder.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Key of a map's meta data: how far images contradict the trajectory that was found from them. */
constexpr const char* kTrajectoryKey = "trajectory";

/** \brief How a map is made of a run. */
struct MapMakingParams {
  MapBuilderParams places;   ///< which images become local models
  MappingParams trajectory;  ///< estimation of poses in a run without them
  ViewParams view;           ///< making of views from images
  int every = 0;             ///< each N-th image becomes a local model, whatever its pose; 0 = by places
  bool distortion = true;    ///< estimate the camera's distortion, and remove it from all images
  bool any_reading = false;  ///< also make a map of images that cannot be right as they are read, and if
                             ///< the poses contradict the images

  /** \brief Throws std::invalid_argument for a parameter out of its range. */
  void validate() const;
};

/** \brief An image that is to become a local model. */
struct MapPlace {
  std::size_t image = 0;                   ///< its number
  std::optional<Eigen::Isometry3d> T_w_m;  ///< nothing where no pose is known in the map's world
};

/** \brief Where a map is made: in memory, or in a file that can be taken up again. */
class MapSink {
public:
  virtual ~MapSink() = default;
  /** \brief The map as it is now. Its poses by links are known once it is whole. */
  virtual std::shared_ptr<Map> map() = 0;
  virtual void setCamera(const Camera& /*camera*/) {}
  virtual void setMeta(const std::string& /*key*/, const std::string& /*value*/) {}
  virtual void add(const Link& /*link*/) {}
  /** \brief All local models and links are there. */
  virtual void setWhole() {}

  /** \brief Results of completeMap(), which map() has got already.
   * The camera has the mounting that was found. */
  virtual void setMounting(const Camera& /*camera*/, const FoundMounting& /*found*/) {}
  /** \brief The sink may keep a place index, unless it has one of this map. */
  virtual void setPlaceIndex(const Map& /*map*/) {}
  /** \brief The scores of aliases are indexed by local model [nats]. */
  virtual void setAmbiguity(const MapAmbiguity& /*ambiguity*/,
                            const std::vector<std::optional<double>>& /*alias_scores*/) {}
};

/** \brief How a map is completed. */
struct MapCompletion {
  bool mounting = false;           ///< find the mounting of a camera without one
  int threads = 1;                 ///< 0 = all cores
  MapProgressCallback progress{};  ///< may be empty
};

/** \brief Ends every map, once its local models and links are there. Adds missing parts, in this order: the
 * mounting of the camera by the floor, a place index, the considered errors (METHOD 2.3), and the ambiguity,
 * which is measured by localizing views of the map in it without their surroundings
 * (localization/METHOD 1.5). \return the mounting, if it was found now */
std::optional<FoundMounting> completeMap(MapSink& sink, const MapCompletion& how = {});
/** \brief Ends a map that is in memory. */
std::optional<FoundMounting> completeMap(const std::shared_ptr<Map>& map, const MapCompletion& how = {});

/** \brief Makes local models of images and adds them to a map, unless they are there. Images without
 * segments make none. \return the index of each one's local model in the map, -1 without one */
using ModelMaker = std::function<std::vector<int>(const std::vector<MapPlace>& places)>;

/** \brief Makes a map of one run of depth images.
 *
 *     facetloc::MapMaking making(camera);
 *     for (...) making.add({name, stamp, [=] { return read(file); }, T_w_c});
 *     const facetloc::Map map = making.finish();
 *
 * The trajectory is found from the images where none of them has a pose; poses that are given are compared
 * with the motions that the images show. Images at some distance from each other become local models, links
 * join them, and the distortion of the camera is estimated and removed. Of a camera whose mounting is
 * unknown, it is found by the floor, if there is one; at last the map's ambiguity is measured. Images are
 * read when they are needed, some of them several times: the distortion is only known once the trajectory is.
 * Same images, same map, for any number of threads.
 *
 * Programs with checks of their own call the steps of finish() in the order in which they are declared here,
 * and end with finish(sink, make), which writes local models one by one and can take up a map again. */
class MapMaking {
public:
  /** \brief Throws std::invalid_argument for a parameter out of its range. */
  explicit MapMaking(const Camera& camera = {}, const MapMakingParams& params = {});
  MapMaking(MapMaking&&) noexcept;
  MapMaking& operator=(MapMaking&&) noexcept;
  ~MapMaking();

  /** \brief Threads; 1 by default, 0 = all cores. */
  void setNumberOfThreads(int n);
  void setProgress(MapProgressCallback progress);
  /** \brief The given poses between the images, too, which shows whether their clock is another one. Unless
   * set, poses are known at the times of images only. */
  void setPosesByTime(PosesByTime poses);
  /** \brief Poses that drift, for a run without other poses, in the axes of its camera. */
  void setOdometry(PosesByTime odometry);
  /** \brief The next image of the run. */
  void add(MapImage image);

  /** \brief The map, in memory; without local models if there is a findings().problem. */
  Map finish();
  const MapFindings& findings() const;

  /** \brief Tests some images for how they are read: findings().geometry. */
  void checkGeometry();
  /** \brief If no image has a pose and local models are not chosen by their number: the trajectory of all
   * images, found in turn with the distortion of their camera. */
  void findTrajectory();
  /** \brief Compares given poses with the images: findings().poses, if any are given. */
  void checkPoses();
  /** \brief The images that are to become local models, in their order. */
  std::vector<MapPlace> places() const;
  /** \brief Makes the places() local models, in a map that may have some of them: distortion, unless the map
   * has been begun with one, local models, links, and completeMap(). \return false if there is no local
   * model. \param make builds views with the camera() */
  bool finish(MapSink& sink, const ModelMaker& make);

  /** \brief Estimates the distortion of the camera() from images with poses, unless the trajectory was found
   * along with it. */
  void findDistortion();
  /** \brief Takes the distortion from elsewhere. */
  void setDistortion(const std::optional<DepthDistortion>& distortion);
  /** \brief Camera for building the views of local models, with the distortion found so far. */
  const Camera& camera() const;
  /** \brief Links of a map whose local models are these images, in ascending order: link ends are indices of
   * these. Throws std::invalid_argument for a number that is no image's. */
  std::vector<Link> links(const std::vector<std::size_t>& images) const;

  /** \brief Pose of an image, given or found; nothing where it is unknown in the map's world. */
  std::optional<Eigen::Isometry3d> pose(std::size_t image) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facetloc
