// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "devices/openni_handle.h"

#include <facetloc/io/error.h>
#include <facetloc/io/oni_file.h>
#include <facetloc/io/virtual_camera.h>
#include <facetloc/openni/openni_grabber.h>

#include <OpenNI.h>
#include <pcl/console/print.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr int kPatience = 10;  // length of a wait for a frame, until it checks whether to give up [ms]
constexpr int kLastWaits = 5;  // so often, after a recording has ended: its last frame may be on its way
constexpr auto kPlayerPause = 30ms;  // libOniFile walks its streams without a lock, every 10 ms
constexpr std::size_t kLongestUri = ONI_MAX_STR - 1;

bool isRecording(const fs::path& path) { return text::lowerExtension(path) == ".oni"; }

/** PCL and OpenNI2 put places in the source and their attempts in front of, and behind, the cause.
 */
std::string causeOf(const std::string& what) {
  const auto says = [&what](const char* words) { return what.find(words) != std::string::npos; };
  if (says("No devices connected"))
    return fmt::format("no depth camera is connected (drivers: {})", openniDriverFolder());
  if (says("Found no files matching")) return "OpenNI2 has no drivers in " + openniDriverFolder();
  if (says("could not find compatible depth stream mode")) return "the device has no such depth mode";
  if (says("No matching device found") || says("Couldn't open device")) {
    const std::string details = openniError();
    return fmt::format("no driver of OpenNI2 can open it (drivers: {}){}", openniDriverFolder(),
                       details.empty() ? "" : ": " + details);
  }
  return what;
}

std::string nameOf(const std::string& device_id) { return device_id.empty() ? "depth camera" : device_id; }

/** Devices are numbered, or have a URI such as 1d27/0601@1/6 or freenect://0. */
bool meansFile(const std::string& device_id) {
  const fs::path path(device_id);
  const bool device = device_id.front() == '#' || device_id.find('@') != std::string::npos ||
                      device_id.find("://") != std::string::npos;
  return !device || path.is_absolute() || isRecording(path) || text::lowerExtension(path) == ".scene";
}

/** OpenNI2's player crashes or blocks on any other recording. */
void requirePlayable(const fs::path& path) {
  const OniFile recording = OniFile::open(path);
  if (!recording.finished())
    throw IoError(path.string(), fmt::format("was never finished, and OpenNI2 does not play it; "
                                             "facetloc_localize and the other tools read its {} frames",
                                             recording.size()));
  recording.requireSound();
}

/** The id for the base class. That takes an existing file for a path and all else for a URI,
 * says of a missing file that no device is connected, and follows a null pointer if a device has no depth. */
std::string checkedId(const std::string& device_id) {
  std::error_code ignored;
  const fs::path path(device_id);
  if (device_id.empty()) return device_id;
  if (!fs::exists(path, ignored)) {
    if (meansFile(device_id)) throw IoError(device_id, "does not exist");
    return device_id;
  }
  // Relative paths would depend on the working directory, which OpenNI2 changes.
  const std::string absolute = fs::absolute(path).lexically_normal().string();
  if (absolute.size() > kLongestUri)
    throw IoError(
        device_id,
        fmt::format("its path is longer than the {} characters that OpenNI2 has room for", kLongestUri));
  if (isRecording(path)) requirePlayable(path);
  return absolute;
}

/** A depth frame that OpenNI2 needs no longer: it may outlive the device, and end on any thread. Holds as
 * many pixels as it says, in millimetres, as PCL takes them for. */
class OwnedFrame : public pcl::io::FrameWrapper {
public:
  /** \param invalid has no depth, in any unit. Throws std::runtime_error. */
  OwnedFrame(const openni::VideoFrameRef& frame, std::uint16_t invalid)
      : depth_(static_cast<std::size_t>(frame.getWidth()) * static_cast<std::size_t>(frame.getHeight())),
        width_(static_cast<unsigned>(frame.getWidth())),
        height_(static_cast<unsigned>(frame.getHeight())),
        index_(static_cast<unsigned>(frame.getFrameIndex())),
        stamp_(frame.getTimestamp()) {
    // The player does not check the size of decoded images.
    if (static_cast<std::size_t>(frame.getDataSize()) != getDataSize())
      throw std::runtime_error(fmt::format("frame {} is corrupt: it has {} bytes instead of {}", index_,
                                           frame.getDataSize(), getDataSize()));
    std::memcpy(depth_.data(), frame.getData(), getDataSize());
    const openni::PixelFormat unit = frame.getVideoMode().getPixelFormat();
    if (unit != openni::PIXEL_FORMAT_DEPTH_1_MM && unit != openni::PIXEL_FORMAT_DEPTH_100_UM)
      throw std::runtime_error(fmt::format("depth in an unknown unit, {}", static_cast<int>(unit)));
    if (unit == openni::PIXEL_FORMAT_DEPTH_100_UM)
      for (std::uint16_t& z : depth_)
        if (z != invalid) z = static_cast<std::uint16_t>((z + 5) / 10);
  }
  const void* getData() const override { return depth_.data(); }
  unsigned getDataSize() const override {
    return static_cast<unsigned>(depth_.size() * sizeof(std::uint16_t));
  }
  unsigned getWidth() const override { return width_; }
  unsigned getHeight() const override { return height_; }
  unsigned getFrameID() const override { return index_; }
  std::uint64_t getTimestamp() const override { return stamp_; }

private:
  std::vector<std::uint16_t> depth_;
  unsigned width_, height_, index_;
  std::uint64_t stamp_;
};

}  // namespace

/** A second handle on the device, with streams of its own. Those of the base class are never started: each
 * calls back on a thread that ends with it, which OpenNI2 does not survive (openni_handle.h). */
struct OpenNIGrabber::State : openni::OpenNI::DeviceStateChangedListener,
                              openni::OpenNI::DeviceDisconnectedListener {
  struct Stream {
    openni::SensorType sensor;
    void (OpenNIGrabber::*process)(openni::VideoStream&);
    bool started = false;
    openni::VideoStream stream = {};
  };

  State(std::string device_uri, bool file) : uri(std::move(device_uri)), is_file(file) {
    if (device.open(uri.c_str()) != openni::STATUS_OK)
      throw IoError(uri, "cannot be controlled: " + openniError());
    openni::OpenNI::addDeviceStateChangedListener(this);  // nothing throws from here on
    openni::OpenNI::addDeviceDisconnectedListener(this);
    has_trigger = device.isPropertySupported(kVirtualCameraTrigger);
  }
  ~State() {
    openni::OpenNI::removeDeviceStateChangedListener(this);
    openni::OpenNI::removeDeviceDisconnectedListener(this);
    for (Stream& s : streams)
      if (s.stream.isValid()) s.stream.destroy();
    device.close();
    // libOniFile does not support this property, but stores any value; only our driver has it.
    if (is_file && !has_trigger) std::this_thread::sleep_for(kPlayerPause);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void onDeviceStateChanged(const openni::DeviceInfo* info, openni::DeviceState state) override {
    if (uri != info->getUri()) return;
    if (state == openni::DEVICE_STATE_EOF)
      told_end = true;
    else
      connected = state == openni::DEVICE_STATE_OK;
  }
  void onDeviceDisconnected(const openni::DeviceInfo* info) override {
    if (uri == info->getUri()) connected = false;
  }
  void setError(const std::string& text) {
    const std::lock_guard lock(error_mutex);
    error = text;
  }

  const std::string uri;
  const bool is_file;
  bool has_trigger = false;  // is it our virtual camera?
  float rate = 0;            // [Hz]
  std::optional<CameraMounting> mounting;
  double focal_length = 0;  // [px]
  openni::Device device;
  std::array<Stream, 3> streams{{{openni::SENSOR_DEPTH, &OpenNIGrabber::readDepth},
                                 {openni::SENSOR_COLOR, &OpenNIGrabber::processColorFrame},
                                 {openni::SENSOR_IR, &OpenNIGrabber::processIRFrame}}};
  std::atomic<bool> told_end = false;
  std::atomic<bool> connected = true;

  std::mutex mutex;  // guards the members below
  std::condition_variable changed;
  bool wanted = false;     // shall frames be read?
  bool reading = false;    // does a thread do so?
  std::thread::id reader;  // that one
  bool ended = false;

  std::mutex error_mutex;
  std::string error;
};

OpenNIGrabber::OpenNIGrabber(const std::string& device_id, Mode depth_mode) try
    : OpenNI2Grabber(checkedId(device_id), depth_mode, OpenNI_Default_Mode),
      state_(std::make_unique<State>(device_->getUri(), device_->isFile())) {
  const auto mode = device_->getDepthVideoMode();
  const float shrunk = static_cast<float>(depth_width_) / mode.x_resolution_;
  state_->rate = static_cast<float>(mode.frame_rate_);
  state_->focal_length = static_cast<double>(shrunk * device_->getDepthFocalLength());
  // Modes that PCL itself makes by leaving pixels out keep the focal length of the larger image.
  if (shrunk != 1) setDepthFocalLength(state_->focal_length);
  std::array<double, 4> k{};
  int size = sizeof k;
  if (shrunk == 1 &&
      state_->device.getProperty(kVirtualCameraIntrinsics, k.data(), &size) == openni::STATUS_OK)
    setDepthCameraIntrinsics(k[0], k[1], k[2], k[3]);
  std::array<double, 6> mounting{};
  size = sizeof mounting;
  if (state_->device.getProperty(kVirtualCameraMounting, mounting.data(), &size) == openni::STATUS_OK)
    state_->mounting =
        CameraMounting{mounting[0], mounting[1], mounting[2], mounting[3], mounting[4], mounting[5]};
  if (!std::isfinite(focalLength()) || !(focalLength() > 0))
    throw IoError(nameOf(device_id), "its driver reports no field of view");
  setPlayback(1, false);
} catch (const IoError&) {
  throw;
} catch (const std::exception& e) {
  throw IoError(nameOf(device_id), causeOf(e.what()));
}

OpenNIGrabber::~OpenNIGrabber() noexcept { stop(); }

void OpenNIGrabber::start() {
  State& s = *state_;
  const std::lock_guard lock(s.mutex);
  if (s.ended) return;
  if (!s.reading) {
    callOnPersistentThread([this] { startStreams(); });
    runOnPersistentThread([this] { readFrames(); });
    s.reading = true;
  }
  s.wanted = true;
  s.changed.notify_all();  // whoever waits in stop() has been overruled
}

void OpenNIGrabber::stop() {
  State& s = *state_;
  std::unique_lock lock(s.mutex);
  s.wanted = false;
  if (s.reader == std::this_thread::get_id()) return;  // a callback: it cannot wait for itself
  s.changed.wait(lock, [&s] { return !s.reading || s.wanted; });
}

void OpenNIGrabber::startStreams() {
  const std::array<bool, 3> required{depth_required_, image_required_, ir_required_};
  for (std::size_t i = 0; i < required.size(); ++i) {
    State::Stream& s = state_->streams[i];
    if (!required[i]) continue;
    const bool created = s.stream.isValid() || s.stream.create(state_->device, s.sensor) == openni::STATUS_OK;
    s.started = created && s.stream.start() == openni::STATUS_OK;
    if (s.started) continue;
    const std::string cause = openniError();
    stopStreams();
    throw IoError(state_->uri, "cannot be started: " + cause);
  }
}

void OpenNIGrabber::stopStreams() {
  for (State::Stream& s : state_->streams)
    if (std::exchange(s.started, false)) s.stream.stop();
}

/** On a persistent thread, until it is stopped, or the recording has ended and its last frame has come. */
void OpenNIGrabber::readFrames() {
  State& s = *state_;
  int waits = 0;
  std::unique_lock lock(s.mutex);
  s.reader = std::this_thread::get_id();
  while (s.wanted && !(s.told_end && waits >= kLastWaits)) {
    lock.unlock();
    waits = readFrame() ? 0 : waits + 1;
    lock.lock();
  }
  stopStreams();
  s.ended = s.told_end;
  s.wanted = s.reading = false;
  s.reader = {};
  s.changed.notify_all();  // with the lock held: whoever waits may destroy us
}

/** Reads a frame if one has come; the base class would wait for ever for one. */
bool OpenNIGrabber::readFrame() {
  std::array<openni::VideoStream*, 3> streams{};
  std::array<State::Stream*, 3> of{};
  int count = 0;
  for (State::Stream& s : state_->streams) {
    if (!s.started) continue;
    streams[static_cast<std::size_t>(count)] = &s.stream;
    of[static_cast<std::size_t>(count++)] = &s;
  }
  int ready = 0;
  const auto status = openni::OpenNI::waitForAnyStream(streams.data(), count, &ready, kPatience);
  if (status != openni::STATUS_OK) {
    if (status != openni::STATUS_TIME_OUT) std::this_thread::sleep_for(std::chrono::milliseconds(kPatience));
    return false;
  }
  State::Stream& s = *of[static_cast<std::size_t>(ready)];
  try {
    (this->*s.process)(s.stream);
  } catch (const std::exception& e) {
    state_->setError(std::string("a callback threw: ") + e.what());
    PCL_ERROR("[OpenNIGrabber] a callback threw: %s\n", e.what());
  } catch (...) {
    state_->setError("a callback threw");
    PCL_ERROR("[OpenNIGrabber] a callback threw\n");
  }
  return true;
}

/** As the base class, but the frame is given back to OpenNI2 before anyone sees it. */
void OpenNIGrabber::readDepth(openni::VideoStream& stream) {
  openni::VideoFrameRef frame;
  if (stream.readFrame(&frame) != openni::STATUS_OK) return;
  const auto invalid = device_->getShadowValue();
  pcl::io::FrameWrapper::Ptr owned;
  try {
    owned = pcl::make_shared<OwnedFrame>(frame, invalid);
  } catch (const std::runtime_error& e) {
    return state_->setError(e.what());
  }
  frame.release();
  depthCallback(pcl::make_shared<pcl::io::DepthImage>(owned, device_->getBaseline(),
                                                      device_->getDepthFocalLength(), invalid, invalid),
                nullptr);
}

void OpenNIGrabber::setPlayback(double speed, bool repeat) {
  if (!isFile()) return;
  callOnPersistentThread([&] {
    openni::PlaybackControl* playback = state_->device.getPlaybackControl();
    if (!playback || playback->setRepeatEnabled(repeat) != openni::STATUS_OK ||
        playback->setSpeed(static_cast<float>(speed)) != openni::STATUS_OK)
      throw IoError(state_->uri, "cannot be played so: " + openniError());
  });
}

void OpenNIGrabber::trigger(int frames) {
  callOnPersistentThread([&] {
    if (!state_->has_trigger ||
        state_->device.setProperty(kVirtualCameraTrigger, frames) != openni::STATUS_OK)
      throw IoError(state_->uri, "cannot be triggered: it is no virtual camera");
  });
}

bool OpenNIGrabber::isRunning() const {
  const std::lock_guard lock(state_->mutex);
  return state_->wanted;
}

bool OpenNIGrabber::isEndOfFile() const {
  const std::lock_guard lock(state_->mutex);
  return state_->ended;
}

bool OpenNIGrabber::isFile() const { return state_->is_file; }
bool OpenNIGrabber::isConnected() const { return state_->connected; }
const std::optional<CameraMounting>& OpenNIGrabber::mounting() const { return state_->mounting; }

const std::string& OpenNIGrabber::uri() const { return state_->uri; }
float OpenNIGrabber::getFramesPerSecond() const { return state_->rate; }

std::string OpenNIGrabber::lastError() const {
  std::array<char, kVirtualCameraTextSize> text{};
  if (state_->has_trigger)
    callOnPersistentThread([&] {
      int size = static_cast<int>(text.size());
      state_->device.getProperty(kVirtualCameraError, text.data(), &size);
    });
  if (text[0]) return text.data();
  const std::lock_guard lock(state_->error_mutex);
  if (state_->error.empty() && !state_->connected) return "the device is gone or reports an error";
  return state_->error;
}

double OpenNIGrabber::focalLength() const {
  const double set = depth_parameters_.focal_length_x;
  return std::isfinite(set) ? set : state_->focal_length;
}

}  // namespace facetloc
