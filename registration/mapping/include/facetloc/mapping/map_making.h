// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/mapping/map_findings.h>
#include <facetloc/mapping/map_image.h>
#include <facetloc/mapping/mapping_params.h>
#include <facetloc/segmentation/view_builder.h>

#include <memory>
#include <optional>
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
 * Programs that write local models one by one, or take up a map again, call the steps of finish() themselves,
 * in the order in which they are declared here. */
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
  /** \brief Estimates the distortion of the camera() from images with poses, unless the trajectory was found
   * along with it. */
  void findDistortion();
  /** \brief Takes the distortion from elsewhere, such as a map that was begun before. */
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

/** \brief Ambiguity of a map, and the scores of the best wrong places that it is computed from. */
struct MapAliases {
  std::optional<MapAmbiguity> ambiguity;      ///< nothing if no view has another place like its own
  std::vector<std::optional<double>> scores;  ///< indexed by local model [nats]
};
/** \brief Localizes views of a map in it without their surroundings: the ambiguity of a map that was made
 * otherwise (localization/METHOD 11.5). \param threads 0 = all cores */
MapAliases findAliases(const std::shared_ptr<const Map>& map, int threads = 1,
                       const MapProgressCallback& progress = {});

}  // namespace facetloc
