// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/depth_image.h>
#include <facetloc/features/finding.h>
#include <facetloc/io/depth_values.h>
#include <facetloc/mapping/map_findings.h>

#include <chrono>
#include <cstdint>
#include <future>
#include <mutex>
#include <unistd.h>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief The judge of a live run: tests some of its first frames for how they are read, as facetloc_check
 * tests the images of a recording, on a thread of its own. */
class LiveFindings {
public:
  explicit LiveFindings(const Camera& camera) : camera_(camera) {}

  /** \brief Takes the frame of a number, from 1; every 10th of the first 160 is tested. */
  void add(std::uint64_t number, const DepthImage& image) {
    const std::lock_guard lock(mutex_);
    if (judged_ || (number - 1) % kEvery != 0 || !image.valid()) return;
    if (!images_.empty() && images_.front().camera != image.camera) return;
    images_.push_back(image);
    if (images_.size() == kImages) judge();
  }

  /** \brief No more frames come: tests those that are there, unless they are fewer than three. Waits. */
  void finish() {
    const std::lock_guard lock(mutex_);
    if (!judged_ && images_.size() >= kLeastImages) judge();
    if (found_.valid()) found_.wait();
  }

  /** \brief Findings that have been made since the last call. */
  Findings take() {
    const std::lock_guard lock(mutex_);
    if (!found_.valid() || found_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    return found_.get();
  }

private:
  static constexpr std::uint64_t kEvery = 10;
  static constexpr std::size_t kImages = 16, kLeastImages = 3;
  static constexpr int kPolite = 10;

  static Findings findingsOf(std::vector<DepthImage> images, const Camera& camera) {
    Findings found = depthFindings(images, camera.max_depth);
    if (firstOf(found, Severity::refusal)) return found;
    for (DepthImage& image : images) dropBeyond(camera.max_depth, image);
    append(checkGeometry(images, camera).findings, found);
    return found;
  }

  void judge() {
    judged_ = true;
    found_ =
        std::async(std::launch::async, [images = std::exchange(images_, {}), camera = camera_]() mutable {
          static_cast<void>(nice(kPolite));  // frames come first; on Linux this is the thread's alone
          return findingsOf(std::move(images), camera);
        });
  }

  const Camera camera_;
  std::mutex mutex_;
  std::vector<DepthImage> images_;  // not yet tested
  bool judged_ = false;
  std::future<Findings> found_;
};

}  // namespace facetloc
