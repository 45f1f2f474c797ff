// SPDX-License-Identifier: BSD-3-Clause
#include "images/depth_file.h"

#include <facetloc/features/depth_image.h>
#include <facetloc/features/organized_cloud.h>
#include <facetloc/io/frame_grabber.h>

#include <condition_variable>
#include <limits>
#include <mutex>
#include <thread>

namespace facetloc {
namespace {

constexpr std::chrono::milliseconds kWakeUp(100);  // to look whether it is to stop
constexpr double kMicroseconds = 1e6;              // per second

pcl::PointCloud<pcl::PointXYZ>::Ptr cloudOf(const DepthImage& image, double stamp) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->width = static_cast<std::uint32_t>(image.camera.width);
  cloud->height = static_cast<std::uint32_t>(image.camera.height);
  cloud->is_dense = false;
  cloud->header.stamp = static_cast<std::uint64_t>(std::max(0.0, stamp) * kMicroseconds);
  cloud->points.reserve(image.depth.size());
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      const float z = image.at(u, v);
      const Eigen::Vector3f p = z * image.camera.ray(u, v).cast<float>();
      cloud->points.push_back(isMeasured(z) ? pcl::PointXYZ(p.x(), p.y(), p.z())
                                            : pcl::PointXYZ(kNone, kNone, kNone));
    }
  return cloud;
}

}  // namespace

DepthImage FrameConverter::operator()(const DepthFrame& frame) {
  DepthImage image;
  image.camera = frame.camera->camera.intrinsics;
  if (frame.values.size() != static_cast<std::size_t>(image.camera.width) * image.camera.height) return {};
  image.depth = metresOf(frame.values, frame.camera->depth_scale);
  return (*this)(std::move(image), frame.camera);
}

DepthImage FrameConverter::operator()(DepthImage stored, const std::shared_ptr<const CameraFile>& camera) {
  if (!camera->isPinhole()) {
    if (camera_ != camera) lens_.emplace(stored.camera, camera->lens, camera->depth_is);
    camera_ = camera;
    stored = (*lens_)(stored);
  }
  fillHoleGrid(stored);
  return stored;
}

struct FrameGrabber::State {
  std::shared_ptr<FrameSource> source;
  FrameConverter converter;
  boost::signals2::signal<OnFrame>* frames = nullptr;
  boost::signals2::signal<OnCloud>* clouds = nullptr;

  mutable std::mutex mutex;  // guards all members below
  std::condition_variable changed;
  bool stopped = true, ended = false, in_turn = false;
  long asked = 0;
  std::string error;
  std::thread thread;

  template <typename Value>
  Value locked(const Value& value) const {
    const std::lock_guard lock(mutex);
    return value;
  }
  template <typename Apply>
  void change(const Apply& apply) {
    const std::lock_guard lock(mutex);
    apply();
    changed.notify_all();
  }
};

FrameGrabber::FrameGrabber(std::shared_ptr<FrameSource> source) : state_(std::make_unique<State>()) {
  state_->source = std::move(source);
  state_->frames = createSignal<OnFrame>();
  state_->clouds = createSignal<OnCloud>();
}

FrameGrabber::~FrameGrabber() noexcept { stop(); }

void FrameGrabber::start() {
  stop();
  state_->change([this] { state_->stopped = false; });
  state_->thread = std::thread([this] { run(); });
}

void FrameGrabber::stop() {
  state_->change([this] { state_->stopped = true; });
  if (state_->thread.joinable()) state_->thread.join();
}

bool FrameGrabber::isRunning() const {
  const std::lock_guard lock(state_->mutex);
  return !state_->stopped && !state_->ended && state_->error.empty();
}

void FrameGrabber::trigger(int frames) {
  state_->change([this, frames] { state_->in_turn = true, state_->asked += frames; });
}

bool FrameGrabber::atEnd() const { return state_->locked(state_->ended); }
std::string FrameGrabber::lastError() const { return state_->locked(state_->error); }
const FrameSource& FrameGrabber::source() const { return *state_->source; }

/** Until a frame may be delivered; false when it is to stop. */
bool FrameGrabber::waitForTurn() {
  std::unique_lock lock(state_->mutex);
  state_->changed.wait(lock, [this] { return state_->stopped || !state_->in_turn || state_->asked > 0; });
  return !state_->stopped;
}

void FrameGrabber::run() try {
  while (waitForTurn() && !state_->source->atEnd()) {
    const DepthFrame::ConstPtr frame = state_->source->next(kWakeUp);
    if (frame) deliver(frame);
  }
  state_->change([this] { state_->ended = !state_->stopped; });
} catch (const std::exception& e) {
  state_->change([&] { state_->error = e.what(); });
}

void FrameGrabber::deliver(const DepthFrame::ConstPtr& frame) {
  state_->change([this] { state_->asked -= state_->in_turn; });
  if (state_->frames->num_slots() > 0) (*state_->frames)(frame);
  if (state_->clouds->num_slots() > 0) (*state_->clouds)(cloudOf(state_->converter(*frame), frame->stamp));
}

}  // namespace facetloc
