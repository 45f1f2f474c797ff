// SPDX-License-Identifier: BSD-3-Clause
#include "frame_source.h"

#include <facetloc/io/virtual_camera.h>

#include <PS1080.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

// OpenNI2's interface of drivers uses macros of a library that is not installed.
#ifndef FALSE
#define FALSE 0
#endif
#ifndef TRUE
#define TRUE 1
#endif
#define XN_NEW(Type, ...) new Type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)
#include <Driver/OniDriverAPI.h>

namespace facetloc {
namespace {

constexpr double kBaseline = 7.5;  // baseline of a Kinect, which the driver simulates [cm]

float fieldOfView(int pixels, double focal_length) {
  return static_cast<float>(2 * std::atan(pixels / (2 * focal_length)));
}

/** Hands a property out, if there is room for it. */
template <typename T>
OniStatus giveProperty(const T& value, void* data, int* size) {
  if (!data || *size < static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof value);
  *size = static_cast<int>(sizeof value);
  return ONI_STATUS_OK;
}

/** The value that a property is set to, if it is of the right size. */
template <typename T>
std::optional<T> takeProperty(const void* data, int size) {
  if (!data || size != static_cast<int>(sizeof(T))) return {};
  T value;
  std::memcpy(&value, data, sizeof value);
  return value;
}

/** Can the property of a device or stream be read? */
template <typename Owner>
OniBool hasProperty(Owner& owner, int id) {
  std::array<char, kVirtualCameraTextSize> value;  // the largest
  int size = static_cast<int>(value.size());
  return owner.getProperty(id, value.data(), &size) == ONI_STATUS_OK;
}

/** Order and times of the images: set by programs through the device, used by the stream's thread. */
class Playback {
public:
  explicit Playback(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

  const FrameSource& source() const { return *source_; }
  float speed() const { return locked(speed_); }
  bool repeats() const { return locked(repeat_); }
  std::string error() const { return locked(error_); }
  void setSpeed(float speed) {
    change([&] { speed_ = speed, due_.reset(); });
  }
  void setRepeat(bool repeat) {
    change([&] { repeat_ = repeat; });
  }
  void setError(const std::string& error) {
    change([&] { error_ = error; });
  }
  /** n >= 0: n more images and no other, as fast as possible; < 0: real time. */
  void trigger(int frames) {
    change([&] {
      credits_ = triggered_ ? credits_ + std::max(frames, 0) : std::max(frames, 0);
      triggered_ = frames >= 0;
      due_.reset();
    });
  }
  void seek(std::size_t index) {
    change([&] { position_ = index, told_end_ = false, due_.reset(); });
  }

  /** Starts playback: next() waits from now on. A sequence that had ended begins again. */
  void start() {
    const std::lock_guard lock(mutex_);
    running_ = true;
    due_.reset();
    if (atEnd()) position_ = 0;
    told_end_ = false;
  }

  /** Ends a wait. */
  void stop() {
    change([this] { running_ = false; });
  }

  /** The image to prepare; nothing when stopped. At the end it calls on_end once, and waits for a
   * change of that. */
  template <typename OnEnd>
  std::optional<std::size_t> next(const OnEnd& on_end) {
    std::unique_lock lock(mutex_);
    while (running_) {
      if (!atEnd()) return position_;
      if (repeat_) {
        position_ = 0;
        due_.reset();
        continue;
      }
      if (!told_end_) {
        told_end_ = true;
        lock.unlock();  // the callback may stop us
        on_end();
        lock.lock();
        continue;
      }
      changed_.wait(lock);
    }
    return {};
  }

  /** Waits until an image is due. False when it is not to be delivered: stopped, or another was
   * sought. */
  bool wait(std::size_t index) {
    std::unique_lock lock(mutex_);
    const std::uint64_t stamp = source_->stamp(index);
    while (running_ && position_ == index) {
      if (!mayDeliver()) {
        changed_.wait(lock);
        continue;
      }
      const auto now = Clock::now();
      // Measured from when the last one was due, so that small delays do not add up; a late one sets a new
      // start.
      auto due = now;
      if (due_ && !triggered_ && speed_ > 0) {
        const std::chrono::duration<double, std::micro> gap(
            (static_cast<double>(stamp) - static_cast<double>(stamp_)) / static_cast<double>(speed_));
        due = *due_ + std::clamp<Clock::duration>(std::chrono::duration_cast<Clock::duration>(gap),
                                                  Clock::duration::zero(), kLongestGap);
        if (due > now) {
          changed_.wait_until(lock, due);
          continue;
        }
        const auto period = std::chrono::microseconds(std::chrono::seconds(1)) / source_->rate();
        if (now - due > period) due = now;
      }
      due_ = due;
      stamp_ = stamp;
      if (triggered_) --credits_;
      ++position_;
      return true;
    }
    return false;
  }

  /** Goes on after an image that cannot be served. */
  void skip(std::size_t index) {
    const std::lock_guard lock(mutex_);
    if (position_ == index) ++position_;
  }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kLongestGap{2};  // between images; a longer one is cut short

  template <typename Value>
  Value locked(const Value& value) const {
    const std::lock_guard lock(mutex_);
    return value;
  }
  template <typename Apply>
  void change(const Apply& apply) {
    const std::lock_guard lock(mutex_);
    apply();
    changed_.notify_all();
  }
  bool atEnd() const { return position_ >= source_->size(); }
  bool mayDeliver() const { return !triggered_ || credits_ > 0; }

  std::unique_ptr<FrameSource> source_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool running_ = false;
  bool repeat_ = true;  // as OpenNI2's own player
  bool told_end_ = false;
  bool triggered_ = false;
  int credits_ = 0;
  float speed_ = 1;
  std::size_t position_ = 0;
  std::optional<Clock::time_point> due_;  // time of the last image delivered
  std::uint64_t stamp_ = 0;               // stamp of that image [us]
  std::string error_;
};

/** The only mode of a source. */
OniVideoMode modeOf(const FrameSource& source) {
  const Intrinsics& camera = source.camera();
  return {ONI_PIXEL_FORMAT_DEPTH_1_MM, camera.width, camera.height, source.rate()};
}

/** The depth stream of a virtual camera: one mode, depth in mm. */
class DepthStream : public oni::driver::StreamBase {
public:
  DepthStream(std::shared_ptr<Playback> playback, std::function<void(int)> report)
      : playback_(std::move(playback)),
        report_(std::move(report)),
        mode_(modeOf(playback_->source())),
        image_(static_cast<std::size_t>(mode_.resolutionX) * mode_.resolutionY) {}

  ~DepthStream() override { stop(); }

  OniStatus start() override {
    if (thread_.joinable()) return ONI_STATUS_OK;
    playback_->start();
    thread_ = std::thread([this] { run(); });
    return ONI_STATUS_OK;
  }

  void stop() override {
    playback_->stop();
    if (thread_.joinable()) thread_.join();
  }

  OniBool isPropertySupported(int id) override { return hasProperty(*this, id); }
  OniStatus getProperty(int id, void* data, int* size) override {
    const Intrinsics& camera = playback_->source().camera();
    switch (id) {
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return giveProperty(mode_, data, size);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      return giveProperty(fieldOfView(camera.width, camera.fx), data, size);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
      return giveProperty(fieldOfView(camera.height, camera.fy), data, size);
    case ONI_STREAM_PROPERTY_STRIDE:
      return giveProperty(stride(), data, size);
    case ONI_STREAM_PROPERTY_MIRRORING:
      return giveProperty(OniBool(FALSE), data, size);
    case ONI_STREAM_PROPERTY_CROPPING:
      return giveProperty(OniCropping{}, data, size);
    case ONI_STREAM_PROPERTY_MAX_VALUE:
      return giveProperty(kMaxDepthMillimetres, data, size);
    case ONI_STREAM_PROPERTY_MIN_VALUE:
      return giveProperty(0, data, size);
    case ONI_STREAM_PROPERTY_NUMBER_OF_FRAMES:
      return giveProperty(static_cast<int>(playback_->source().size()), data, size);
    case XN_STREAM_PROPERTY_EMITTER_DCMOS_DISTANCE:
      return giveProperty(kBaseline, data, size);
    default:
      return ONI_STATUS_NOT_IMPLEMENTED;
    }
  }

  /** There is nothing to choose: one mode, not mirrored, not cropped. */
  OniStatus setProperty(int id, const void* data, int size) override {
    const auto allowed = [](bool yes) { return yes ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED; };
    if (id == ONI_STREAM_PROPERTY_VIDEO_MODE) {
      const auto mode = takeProperty<OniVideoMode>(data, size);
      return allowed(mode && mode->pixelFormat == mode_.pixelFormat && mode->fps == mode_.fps &&
                     mode->resolutionX == mode_.resolutionX && mode->resolutionY == mode_.resolutionY);
    }
    if (id == ONI_STREAM_PROPERTY_MIRRORING) {
      const auto mirror = takeProperty<OniBool>(data, size);
      return allowed(mirror && !*mirror);
    }
    if (id == ONI_STREAM_PROPERTY_CROPPING) {
      const auto cropping = takeProperty<OniCropping>(data, size);
      return allowed(cropping && !cropping->enabled);
    }
    return ONI_STATUS_NOT_IMPLEMENTED;
  }

private:
  int stride() const { return mode_.resolutionX * static_cast<int>(sizeof(OniDepthPixel)); }
  void run() {
    const FrameSource& source = playback_->source();
    while (const auto index = playback_->next([this] { report_(ONI_DEVICE_STATE_EOF); })) {
      try {
        source.read(*index, image_.data());  // ahead of its time, to be punctual
      } catch (const std::exception& e) {    // one image is lost, as cameras do
        playback_->setError(e.what());
        playback_->skip(*index);
        continue;
      }
      if (playback_->wait(*index)) deliver(source.stamp(*index));
    }
  }

  void deliver(std::uint64_t stamp) {
    OniFrame* frame = getServices().acquireFrame();
    if (!frame) return;
    frame->sensorType = ONI_SENSOR_DEPTH;
    frame->timestamp = stamp;
    frame->frameIndex = ++number_;
    frame->videoMode = mode_;
    frame->width = mode_.resolutionX;
    frame->height = mode_.resolutionY;
    frame->croppingEnabled = FALSE;
    frame->cropOriginX = frame->cropOriginY = 0;
    frame->stride = stride();
    frame->dataSize = stride() * mode_.resolutionY;
    std::memcpy(frame->data, image_.data(), static_cast<std::size_t>(frame->dataSize));
    raiseNewFrame(frame);
    getServices().releaseFrame(frame);
  }

  std::shared_ptr<Playback> playback_;
  std::function<void(int)> report_;
  OniVideoMode mode_{};
  std::vector<OniDepthPixel> image_;  // the next one
  int number_ = 0;                    // number of the last one delivered
  std::thread thread_;
};

/** A virtual camera: one depth stream, played like a recording as far as OpenNI2 can tell. */
class DepthDevice : public oni::driver::DeviceBase {
public:
  DepthDevice(std::unique_ptr<FrameSource> source, std::function<void(int)> report)
      : playback_(std::make_shared<Playback>(std::move(source))),
        report_(std::move(report)),
        mode_(modeOf(playback_->source())),
        sensor_{ONI_SENSOR_DEPTH, 1, &mode_} {}

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = &sensor_;
    *count = 1;
    return ONI_STATUS_OK;
  }

  oni::driver::StreamBase* createStream(OniSensorType type) override {
    if (type != ONI_SENSOR_DEPTH || has_stream_) return nullptr;
    has_stream_ = true;
    return new DepthStream(playback_, report_);
  }

  void destroyStream(oni::driver::StreamBase* stream) override {
    delete stream;
    has_stream_ = false;
  }

  OniBool isPropertySupported(int id) override {
    return id == kVirtualCameraTrigger || hasProperty(*this, id);
  }

  OniStatus getProperty(int id, void* data, int* size) override {
    switch (id) {
    case ONI_DEVICE_PROPERTY_DRIVER_VERSION:
      return giveProperty(OniVersion{0, 1, 0, 0}, data, size);
    case ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION:
      return giveProperty(ONI_IMAGE_REGISTRATION_OFF, data, size);
    case ONI_DEVICE_PROPERTY_PLAYBACK_SPEED:
      return giveProperty(playback_->speed(), data, size);
    case ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED:
      return giveProperty(OniBool(playback_->repeats()), data, size);
    case kVirtualCameraError: {
      std::array<char, kVirtualCameraTextSize> text{};
      const std::string error = playback_->error();
      std::copy_n(error.begin(), std::min(error.size(), text.size() - 1), text.begin());
      return giveProperty(text, data, size);
    }
    case kVirtualCameraIntrinsics: {
      const Intrinsics& camera = playback_->source().camera();
      return giveProperty(std::array<double, 4>{camera.fx, camera.fy, camera.cx, camera.cy}, data, size);
    }
    case kVirtualCameraMounting: {
      const std::optional<CameraMounting>& mounting = playback_->source().mounting();
      if (!mounting) return ONI_STATUS_NOT_IMPLEMENTED;
      return giveProperty(std::array<double, 6>{mounting->height, mounting->tilt_deg, mounting->roll_deg,
                                                mounting->pan_deg, mounting->x, mounting->y},
                          data, size);
    }
    default:
      return ONI_STATUS_NOT_IMPLEMENTED;
    }
  }

  OniStatus setProperty(int id, const void* data, int size) override {
    switch (id) {
    case ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION: {
      const auto mode = takeProperty<OniImageRegistrationMode>(data, size);
      return mode && *mode == ONI_IMAGE_REGISTRATION_OFF ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
    }
    case ONI_DEVICE_PROPERTY_PLAYBACK_SPEED: {
      const auto speed = takeProperty<float>(data, size);
      if (!speed || !std::isfinite(*speed) || *speed < 0) return ONI_STATUS_BAD_PARAMETER;
      playback_->setSpeed(*speed);
      return ONI_STATUS_OK;
    }
    case ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED: {
      const auto repeat = takeProperty<OniBool>(data, size);
      if (!repeat) return ONI_STATUS_BAD_PARAMETER;
      playback_->setRepeat(*repeat);
      return ONI_STATUS_OK;
    }
    case kVirtualCameraTrigger: {
      const auto frames = takeProperty<int>(data, size);
      if (!frames) return ONI_STATUS_BAD_PARAMETER;
      playback_->trigger(*frames);
      return ONI_STATUS_OK;
    }
    default:
      return ONI_STATUS_NOT_IMPLEMENTED;
    }
  }

  OniBool isCommandSupported(int command) override { return command == ONI_DEVICE_COMMAND_SEEK; }
  OniStatus invoke(int command, void* data, int size) override {
    if (command != ONI_DEVICE_COMMAND_SEEK) return ONI_STATUS_NOT_IMPLEMENTED;
    const auto seek = takeProperty<OniSeek>(data, size);
    if (!seek || seek->frameIndex < 0) return ONI_STATUS_BAD_PARAMETER;
    playback_->seek(static_cast<std::size_t>(std::max(seek->frameIndex, 1) - 1));  // the first frame is 1
    return ONI_STATUS_OK;
  }

private:
  std::shared_ptr<Playback> playback_;
  std::function<void(int)> report_;
  OniVideoMode mode_;
  OniSensorInfo sensor_{};
  bool has_stream_ = false;  // OpenNI2 shares one among its handles
};

/** Turns paths into devices. */
class Driver : public oni::driver::DriverBase {
public:
  explicit Driver(OniDriverServices* services) : DriverBase(services) {}

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback state_changed, void* cookie) override {
    const OniStatus status = DriverBase::initialize(connected, disconnected, state_changed, cookie);
    const char* path = std::getenv(kVirtualCameraAnnounce);
    if (status == ONI_STATUS_OK && path && isFrameSource(path)) announce(path);
    return status;
  }
  void shutdown() override {}

  /** Claims files that look like ours; their faults are reported when they are opened. */
  OniStatus tryDevice(const char* uri) override {
    if (std::strlen(uri) >= ONI_MAX_STR || !isFrameSource(uri)) return ONI_STATUS_ERROR;
    announce(uri);
    return ONI_STATUS_OK;
  }

  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    try {
      const OniDeviceInfo& info = announced(uri);
      return new DepthDevice(openFrameSource(uri),
                             [this, &info](int state) { deviceStateChanged(&info, state); });
    } catch (const std::exception& e) {
      getServices().errorLoggerAppend("%s", e.what());
      return nullptr;
    }
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }

private:
  OniDeviceInfo& announced(const std::string& uri) {
    const std::lock_guard lock(mutex_);
    return infos_[uri];
  }

  void announce(const std::string& uri) {
    OniDeviceInfo& info = announced(uri);
    info = {};
    const auto put = [](char(&field)[ONI_MAX_STR], const std::string& text) {
      std::strncpy(field, text.c_str(), ONI_MAX_STR - 1);
    };
    put(info.uri, uri);
    put(info.vendor, "facetloc");
    put(info.name, "virtual depth camera");
    deviceConnected(&info);
  }

  std::mutex mutex_;
  std::map<std::string, OniDeviceInfo> infos_;  // OpenNI2 keeps pointers to them
};

}  // namespace
}  // namespace facetloc

ONI_EXPORT_DRIVER(facetloc::Driver)
