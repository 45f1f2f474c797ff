// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "calibration/pose_check.h"
#include "sessions/parallel_stage.h"

#include <facetloc/features/depth_picture.h>
#include <facetloc/mapping/map_findings.h>
#include <facetloc/segmentation/view_builder.h>

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace facetloc::internal {

/** \brief Things kept of some images of a run once they are read, so that a later step need not read them
 * again: of those that are asked for, however long the run is. Thread-safe but for ask(). */
template <typename Thing>
class KeptOfImages {
public:
  /** \brief Gives up the things of other images. */
  void ask(const std::vector<std::size_t>& images) {
    std::map<std::size_t, std::optional<Thing>> asked;
    for (const std::size_t image : images) asked.try_emplace(image, std::move(things_[image]));
    things_ = std::move(asked);
  }

  /** \brief Is it asked for, and not there? */
  bool lacks(std::size_t image) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = things_.find(image);
    return found != things_.end() && !found->second;
  }

  /** \brief If it is asked for and not there. */
  void keep(std::size_t image, Thing thing) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = things_.find(image);
    if (found != things_.end() && !found->second) found->second.emplace(std::move(thing));
  }

  /** \brief Null if it is not there; valid until ask(). */
  const Thing* find(std::size_t image) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = things_.find(image);
    return found != things_.end() && found->second ? &*found->second : nullptr;
  }

private:
  mutable std::mutex mutex_;
  std::map<std::size_t, std::optional<Thing>> things_;
};

/** \brief Builds views for several threads. */
class ViewBuilders {
public:
  ViewBuilders(const Camera& camera, const ViewParams& params) : camera_(camera), params_(params) {}
  View build(const DepthImage& image, const std::optional<Gravity>& gravity);

private:
  Camera camera_;
  ViewParams params_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<ViewBuilder>> idle_;
};

/** \brief The images of a run, and how they are read and worked on. */
struct ImageRun {
  Camera camera;
  ViewParams view;
  std::vector<MapImage> images;
  PosesByTime odometry;  // may be empty
  int threads = 1;
  MapProgressCallback progress;
  mutable KeptOfImages<DepthImage> kept_images;
  mutable KeptOfImages<DepthPicture> kept_pictures;

  ParallelStage stage(MapProgress::Stage stage, std::size_t items) const {
    return {stage, items, threads, progress};
  }
  bool hasPoses() const;
  std::vector<std::size_t> all() const;
  /** \brief Some dozen images from all over the run, which show the same as hundreds. */
  std::vector<std::size_t> sample() const;

  /** \brief Reads an image unless it is kept, and keeps it or its picture if asked to. Thread-safe. Throws as
   * MapImage::load. */
  DepthImage read(std::size_t image) const;
  View viewOf(std::size_t image, ViewBuilders& builders) const {
    return builders.build(read(image), images[image].gravity);
  }

  /** \brief Receives a view, in the order of the images; nothing of an image that could not be read. */
  using Take = std::function<void(std::size_t image, std::optional<View> view)>;
  /** \brief Builds views, some at a time, and hands them over in order.
   * \param unread takes the images that could not be read */
  void buildViews(const std::vector<std::size_t>& images, MapProgress::Stage stage,
                  std::vector<UnreadImage>& unread, const Take& take) const;

  /** \brief The trajectory of all images; those that cannot be read are where they are between the others.
   * Fills in findings. */
  CameraTrajectory findTrajectory(const MappingParams& params, MapFindings& findings) const;
  /** \brief Rotates each part of the trajectory so that the z axis of its world points upwards, by the
   * gravity that was measured with its images; parts without any stay. */
  void level(CameraTrajectory& trajectory) const;

  /** \brief How the camera moved at some places of the run, by its images alone: pairs of images, of which
   * one is registered with the other and the answer is sure. Images that cannot be read are left out. */
  std::vector<SeenMotion> seenMotions() const;
  /** \brief Looks at steps between neighbouring images that are longer by the poses than those around them:
   * jumps if they are far longer than usual, and shorter by the images or too fast for any camera; else
   * outliers of the check if the images contradict them. The largest first. */
  std::vector<PoseJump> poseJumps(PoseCheck& check) const;
};

}  // namespace facetloc::internal
