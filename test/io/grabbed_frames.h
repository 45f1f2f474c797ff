// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "watchdog.h"

#include <facetloc/openni/openni_grabber.h>

#include <pcl/point_types.h>

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <vector>

namespace facetloc::test {

/** \brief A depth image as a grabber delivers it. */
struct GrabbedFrame {
  int index = 0;            ///< as the driver counts
  std::uint64_t stamp = 0;  ///< [us]
  std::vector<std::uint16_t> depth;
};

/** \brief Collects the frames of a grabber. To be made before start(). */
class GrabbedFrames {
public:
  explicit GrabbedFrames(OpenNIGrabber& grabber) : grabber_(grabber) {
    connection_ = grabber.registerCallback<void(const pcl::io::DepthImage::Ptr&)>(
        [this](const pcl::io::DepthImage::Ptr& d) {
          GrabbedFrame frame{static_cast<int>(d->getFrameID()), d->getTimestamp(), {}};
          frame.depth.assign(d->getData(), d->getData() + std::size_t(d->getWidth()) * d->getHeight());
          const std::lock_guard lock(mutex_);
          frames_.push_back(std::move(frame));
          arrived_.notify_all();
        });
  }
  ~GrabbedFrames() {
    grabber_.stop();
    connection_.disconnect();
  }
  GrabbedFrames(const GrabbedFrames&) = delete;
  GrabbedFrames& operator=(const GrabbedFrames&) = delete;
  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return frames_.size();
  }
  std::vector<GrabbedFrame> frames() const {
    const std::lock_guard lock(mutex_);
    return frames_;
  }
  bool waitFor(std::size_t count) const {
    std::unique_lock lock(mutex_);
    return arrived_.wait_for(lock, kPatience, [&] { return frames_.size() >= count; });
  }

private:
  OpenNIGrabber& grabber_;
  boost::signals2::connection connection_;
  mutable std::mutex mutex_;
  mutable std::condition_variable arrived_;
  std::vector<GrabbedFrame> frames_;
};

}  // namespace facetloc::test
