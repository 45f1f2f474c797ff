// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/depth_image.h>
#include <facetloc/features/finding.h>

#include <cstdint>
#include <future>
#include <mutex>
#include <vector>

namespace facetloc {

/** \brief The judge of a live run: tests some of its first frames for how they are read, as facetloc_check
 * tests the images of a recording, on a thread of its own. */
class LiveFindings {
public:
  explicit LiveFindings(const Camera& camera) : camera_(camera) {}

  /** \brief Takes the frame of a number, from 1; every 10th of the first 160 is tested. */
  void add(std::uint64_t number, const DepthImage& image);
  /** \brief No more frames come: tests those that are there, unless they are fewer than three. Waits. */
  void finish();
  /** \brief Findings that have been made since the last call. */
  Findings take();

private:
  void judge();

  const Camera camera_;
  std::mutex mutex_;
  std::vector<DepthImage> images_;  // not yet tested
  bool judged_ = false;
  std::future<Findings> found_;
};

}  // namespace facetloc
