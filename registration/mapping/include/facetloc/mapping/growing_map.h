// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A map that grows with each image of a moving camera, for hours: images become local models by the
 * rule of MapBuilder, but none where there is one already. Its poses, relative to each other, get better
 * whenever loops are closed, which another thread may do on a clone().
 *
 *     facetloc::GrowingMap map;
 *     for (...) if (map.add(view, name, stamp)) keep(view);
 *     map.improve();
 *
 * Nothing grows with time alone; with new places, keyframes (0.2 MB each) and segments do. MapMaking makes
 * better maps of images that can be read again: here the distortion of the camera stays in. */
class GrowingMap {
public:
  explicit GrowingMap(const MappingParams& trajectory = {}, const MapBuilderParams& places = {});
  GrowingMap(GrowingMap&&) noexcept;
  GrowingMap& operator=(GrowingMap&&) noexcept;
  ~GrowingMap();

  /** \brief Takes the next image. \param motion of the camera since the image before, by an odometry
   * \return true if it has become a local model, the last one. */
  bool add(const View& view, const std::string& name, double stamp,
           const std::optional<Eigen::Isometry3d>& motion = {});
  /** \brief The next image may show any other place. */
  void interrupt();

  /** \brief Pose of the camera at the latest image; nothing where nothing leads to it from the largest part
   * of the map. */
  std::optional<PoseWithCovariance> latest() const;
  int size() const;  ///< number of local models
  int keyframes() const;
  int loops() const;  ///< number of loops closed so far
  /** \brief Positions of the camera at the keyframes of the largest part, in their order. */
  std::vector<Eigen::Vector3d> trajectory() const;

  /** \brief Are there keyframes that improve() has not compared? */
  bool canBeImproved() const;
  /** \brief Compares new keyframes with earlier ones, closes loops and optimizes all poses.
   * \param progress if given, is called with the share of the work that is done, from one thread */
  void improve(const std::function<void(double)>& progress = {});
  /** \brief A copy, to be improved by another thread while images are added here. Views are shared. */
  GrowingMap clone() const;
  /** \brief Takes the poses of an improved clone. \return the largest distance by which a keyframe has moved
   * [m]; infinite if another part is the largest now. */
  double adopt(const GrowingMap& improved);

  /** \brief T_w_m of each local model; nothing outside the largest part. */
  std::vector<std::optional<Eigen::Isometry3d>> poses() const;
  /** \brief Links from each local model to those next on the way, and between those whose keyframes have
   * closed a loop. */
  std::vector<Link> links() const;
  /** \brief The map as it is now, without depth pictures. */
  std::shared_ptr<const Map> map(const Camera& camera) const;

private:
  struct Impl;
  explicit GrowingMap(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace facetloc
