// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/frame_source.h>

#include <pcl/io/grabber.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <memory>
#include <string>

namespace facetloc {

/** \brief A pcl::Grabber of a FrameSource: a pipe, or a camera of Linux's video drivers.
 *
 *     facetloc::FrameGrabber grabber(std::make_shared<facetloc::V4l2Frames>("/dev/video2", camera));
 *     grabber.registerCallback<void(const facetloc::DepthFrame::ConstPtr&)>(use);
 *     grabber.start();
 *
 * Its callbacks are `void(const facetloc::DepthFrame::ConstPtr&)`, which costs nothing, and
 * `void(const pcl::PointCloud<pcl::PointXYZ>::ConstPtr&)`, organized, NaN where nothing was measured, stamp
 * in microseconds. They are registered before start() and run one at a time on a thread of the grabber. */
class FrameGrabber : public pcl::Grabber {
public:
  using OnFrame = void(const DepthFrame::ConstPtr&);
  using OnCloud = void(const pcl::PointCloud<pcl::PointXYZ>::ConstPtr&);

  explicit FrameGrabber(std::shared_ptr<FrameSource> source);
  /** \brief Stops. Not to be called by a callback. */
  ~FrameGrabber() noexcept override;

  void start() override;
  /** \brief When it returns, no callback runs and none will. Frames that the source has read are kept for the
   * next start. */
  void stop() override;
  /** \brief Has it been started, and neither stopped, nor ended, nor failed? */
  bool isRunning() const override;
  std::string getName() const override { return "FrameGrabber"; }
  /** \brief 0: sources do not say it. */
  float getFramesPerSecond() const override { return 0; }

  /** \brief Requests this number of further frames; after the first call, only requested ones arrive. A
   * source that sends faster waits. */
  void trigger(int frames);
  /** \brief Has the source ended as it should, and the last callback returned? */
  bool atEnd() const;
  /** \brief The fault that made it stop: of the source, or an exception of a callback; empty without a fault.
   */
  std::string lastError() const;
  const FrameSource& source() const;

private:
  struct State;
  void run();
  bool waitForTurn();
  void deliver(const DepthFrame::ConstPtr& frame);

  std::unique_ptr<State> state_;
};

}  // namespace facetloc
