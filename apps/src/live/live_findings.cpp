// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_findings.h"

#include <facetloc/io/depth_values.h>
#include <facetloc/mapping/map_findings.h>

#include <chrono>
#include <unistd.h>
#include <utility>

namespace facetloc {
namespace {

constexpr std::uint64_t kEvery = 10;
constexpr std::size_t kImages = 16, kLeastImages = 3;
constexpr int kPolite = 10;

Findings findingsOf(std::vector<DepthImage> images, const Camera& camera) {
  Findings found = depthFindings(images, camera.max_depth);
  if (firstOf(found, Severity::refusal)) return found;
  for (DepthImage& image : images) dropBeyond(camera.max_depth, image);
  append(checkGeometry(images, camera).findings, found);
  return found;
}

}  // namespace

void LiveFindings::judge() {
  judged_ = true;
  found_ = std::async(std::launch::async, [images = std::exchange(images_, {}), camera = camera_]() mutable {
    static_cast<void>(nice(kPolite));  // frames come first; on Linux this is the thread's alone
    return findingsOf(std::move(images), camera);
  });
}

void LiveFindings::add(std::uint64_t number, const DepthImage& image) {
  const std::lock_guard lock(mutex_);
  if (judged_ || (number - 1) % kEvery != 0 || !image.valid()) return;
  if (!images_.empty() && images_.front().camera != image.camera) return;
  images_.push_back(image);
  if (images_.size() == kImages) judge();
}

void LiveFindings::finish() {
  const std::lock_guard lock(mutex_);
  if (!judged_ && images_.size() >= kLeastImages) judge();
  if (found_.valid()) found_.wait();
}

Findings LiveFindings::take() {
  const std::lock_guard lock(mutex_);
  if (!found_.valid() || found_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
  return found_.get();
}

}  // namespace facetloc
