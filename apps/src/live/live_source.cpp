// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_source.h"

#include "base/text.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/depth_values.h>
#include <facetloc/io/error.h>
#include <facetloc/io/v4l2_frames.h>
#include <facetloc/openni/openni_grabber.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fmt/format.h>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <unistd.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using DevicePicture = pcl::io::DepthImage;

constexpr double kMicrosecond = 1e-6;           // [s]
constexpr double kMillimetre = 1e-3;            // [m]
constexpr std::chrono::seconds kFirstFrame(3);  // longest wait for a frame, whose size reveals the camera
constexpr const char* kPipe = "-";

/** Intrinsics for an image of another size: every step-th pixel, as our subsampling and OpenNI's modes. */
Intrinsics scaledTo(const Intrinsics& camera, int width, int height) {
  if (width <= 0 || camera.width % width != 0 || camera.width / width * height != camera.height)
    throw std::runtime_error(fmt::format("the camera file is of an image of {}x{}, the device sends {}x{}",
                                         camera.width, camera.height, width, height));
  return camera.subsampled(camera.width / width);
}

DepthImage toDepthImage(const DevicePicture& picture, const std::optional<Intrinsics>& camera) {
  DepthImage image;
  const double f = picture.getFocalLength();
  const int w = static_cast<int>(picture.getWidth()), h = static_cast<int>(picture.getHeight());
  // PCL's intrinsics of the device's field of view: square pixels, the centre in the middle.
  image.camera = camera ? scaledTo(*camera, w, h) : Intrinsics{w, h, f, f, (w - 1) / 2.0, (h - 1) / 2.0};
  const std::size_t n = static_cast<std::size_t>(picture.getWidth()) * picture.getHeight();
  std::vector<unsigned short> raw(n);
  if (picture.getMetaData()->getDataSize() != n * sizeof raw[0])  // PCL copies as many bytes as there are
    throw std::runtime_error("a depth image of the source is corrupt");
  picture.fillDepthImageRaw(picture.getWidth(), picture.getHeight(), raw.data());
  const auto unknown = static_cast<unsigned short>(picture.getNoSampleValue());
  const auto shadow = static_cast<unsigned short>(picture.getShadowValue());
  image.depth.resize(n);
  std::transform(raw.begin(), raw.end(), image.depth.begin(), [&](unsigned short z) {
    return z == unknown || z == shadow ? 0.f : static_cast<float>(kMillimetre * z);
  });
  return image;
}

/** Frames as a pinhole camera's. */
FrameSink corrected(const CameraFile& camera, const FrameSink& sink) {
  auto lens = std::make_shared<std::optional<LensCorrection>>();  // kept while the size of frames stays
  return [lens, camera, sink](LiveFrame frame) {
    frame.image = [lens, camera, image = std::move(frame.image)] {
      const DepthImage stored = image();
      if (stored.valid() && (!*lens || (*lens)->camera() != stored.camera))
        lens->emplace(stored.camera, camera.lens, camera.depth_is);
      return stored.valid() ? (**lens)(stored) : stored;
    };
    sink(std::move(frame));
  };
}

/** The calibration set in the grabber by our virtual camera, or a program; empty for other devices. */
std::optional<Intrinsics> calibrationOf(const OpenNIGrabber& grabber) {
  const auto mode = grabber.getDevice()->getDepthVideoMode();
  Intrinsics k{mode.x_resolution_, mode.y_resolution_, 0, 0, 0, 0};
  grabber.getDepthCameraIntrinsics(k.fx, k.fy, k.cx, k.cy);
  return k.valid() ? std::optional(k) : std::nullopt;
}

/** PCL's compressed images, which OpenNI2 does not know. */
bool isPclzfFolder(const fs::path& path) {
  std::error_code ignored;
  const fs::directory_iterator files(path, ignored);
  return std::any_of(begin(files), end(files), [](const fs::directory_entry& entry) {
    return text::lowerExtension(entry.path()) == ".pclzf";
  });
}

/** Without OpenNI2: all that it does not know, and every file whose frames are to wait, but for our virtual
 * cameras, which wait themselves. */
bool isPlayed(const LiveSourceOptions& options) {
  const fs::path path = options.device;
  std::error_code ignored;
  if (V4l2Frames::reads(path)) return false;
  if (text::lowerExtension(path) == ".scene" || !fs::exists(path, ignored)) return false;
  if (options.every_frame || DepthSequence::isOfMessages(path) || isPclzfFolder(path)) return true;
  return fs::is_regular_file(path, ignored) && text::lowerExtension(path) != ".oni";
}

/** The camera given by --camera; without intrinsics for such a preset, empty for a map. */
std::optional<CameraFile> givenCamera(const std::string& camera) {
  if (camera.empty() || isMapFile(camera)) return {};
  const CameraPreset* preset = fs::exists(camera) ? nullptr : findCameraPreset(camera);
  if (!preset) return readCameraFile(camera);
  CameraFile file;
  file.preset = preset->name;
  file.camera = preset->camera();
  return file;
}

}  // namespace

/** Plays a recording of any layout image by image, by their times or each when it is asked for.
 *
 * Images that cannot be read, or are of another size than the first one, are skipped. */
class FilePlayer {
public:
  /** \brief Throws IoError unless the recording can be read. */
  explicit FilePlayer(const LiveSourceOptions& options)
      : options_(options), sequence_(DepthSequence::open(options.device, hintsOf(options))) {}
  ~FilePlayer() { stop(); }

  /** \brief Plays to the sink, on a thread of its own; once. */
  void start(const FrameSink& sink) {
    thread_ = std::thread([this, sink] { run(sink); });
  }

  /** \brief When it returns, the sink is not called any more. */
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  /** \brief With LiveSourceOptions::every_frame: also gives the next image to the sink. */
  void next() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++asked_;
    changed_.notify_all();
  }

  const std::optional<CameraFile>& camera() const { return sequence_.camera(); }
  /** \brief Findings of reading its files. */
  Findings findings() const { return readingFindings(sequence_); }
  /** \brief Is there no image left? Never with repeat. */
  bool atEnd() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return ended_;
  }

  /** \brief Why the last image that was skipped could not be read; empty if all could. */
  std::string lastError() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return error_;
  }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kUsualRate = 30;  // [Hz] of images without times
  static constexpr double kLongestGap = 2;  // [s] between images; a longer one in the stamps is cut short
  static constexpr double kLate = 0.1;      // [s] after which being late sets a new start

  static RecordingHints hintsOf(const LiveSourceOptions& options) {
    RecordingHints hints;
    hints.camera = options.camera;
    hints.topic = options.topic;
    return hints;
  }

  void run(const FrameSink& sink) {
    do {
      playOnce(sink);
      const std::lock_guard<std::mutex> lock(mutex_);
      due_.reset();
      if (stopped_) return;
    } while (options_.repeat && width_ > 0);
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
  }

  void playOnce(const FrameSink& sink) {
    for (std::size_t i = 0; i < sequence_.frames().size(); ++i) {
      std::optional<DepthImage> loaded = load(i);  // ahead of its time, to be punctual
      if (!loaded) continue;
      const auto image = std::make_shared<const DepthImage>(std::move(*loaded));
      if (!wait(stampOf(i))) return;
      sink({stampOf(i), [image] { return *image; }});
    }
  }

  std::optional<DepthImage> load(std::size_t index) try {
    DepthImage image = sequence_.load(index);
    if (width_ == 0) width_ = image.camera.width, height_ = image.camera.height;
    if (image.camera.width == width_ && image.camera.height == height_) return image;
    throw IoError(sequence_.frames()[index].path.string(), "is of another size than the first image");
  } catch (const std::exception& e) {
    const std::lock_guard<std::mutex> lock(mutex_);
    error_ = e.what();
    return {};
  }

  /** Until an image is due; false when the player is stopped. */
  bool wait(double stamp) {
    std::unique_lock<std::mutex> lock(mutex_);
    if (options_.every_frame) changed_.wait(lock, [this] { return stopped_ || asked_ > 0; });
    auto due = Clock::now();
    if (due_ && options_.speed > 0) {
      // Measured from when the last one was due, so that small delays do not add up.
      const double gap = std::clamp(stamp - stamp_, 0.0, kLongestGap) / options_.speed;
      const auto planned =
          *due_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(gap));
      if (due - planned < std::chrono::duration<double>(kLate)) due = planned;
      changed_.wait_until(lock, due, [this] { return stopped_; });
    }
    due_ = due;
    stamp_ = stamp;
    if (options_.every_frame && !stopped_) --asked_;
    return !stopped_;
  }

  double stampOf(std::size_t index) const {
    return sequence_.stamped() ? sequence_.frames()[index].stamp : static_cast<double>(index) / kUsualRate;
  }

  const LiveSourceOptions options_;
  const DepthSequence sequence_;
  int width_ = 0, height_ = 0;  // size of the first image [px]
  mutable std::mutex mutex_;    // guards the members below
  std::condition_variable changed_;
  bool stopped_ = false, ended_ = false;
  std::uint64_t asked_ = 1;  // images that were asked for and not delivered
  std::optional<Clock::time_point> due_;
  double stamp_ = 0;  // stamp of the image that was due then [s]
  std::string error_;
  std::thread thread_;
};

void connectFrames(pcl::Grabber& grabber, const std::optional<Intrinsics>& camera, const FrameSink& sink) {
  using OnPicture = void(const DevicePicture::Ptr&);
  if (grabber.providesCallback<FrameGrabber::OnFrame>()) {
    auto convert = std::make_shared<FrameConverter>();
    grabber.registerCallback<FrameGrabber::OnFrame>([convert, sink](const DepthFrame::ConstPtr& frame) {
      sink({frame->stamp, [convert, frame] { return (*convert)(*frame); }, frame->gravity});
    });
  } else if (grabber.providesCallback<OnPicture>()) {
    grabber.registerCallback<OnPicture>([camera, sink](const DevicePicture::Ptr& picture) {
      sink({kMicrosecond * static_cast<double>(picture->getTimestamp()),
            [picture, camera] { return toDepthImage(*picture, camera); }});
    });
  } else {
    throw std::runtime_error(grabber.getName() + " has no depth images");
  }
}

std::shared_ptr<PipeFrames> LiveSource::pipeOf(const LiveSourceOptions& options) {
  if (options.device != kPipe) return {};
  return std::make_shared<PipeFrames>(STDIN_FILENO, "standard input", givenCamera(options.camera));
}

LiveSource::LiveSource(const LiveSourceOptions& options, std::shared_ptr<PipeFrames> pipe)
    : every_frame_(options.every_frame), name_(options.device), pipe_(std::move(pipe)) {
  if (isPlayed(options)) {
    player_ = std::make_unique<FilePlayer>(options);
    camera_ = player_->camera();
    return;
  }
  const std::optional<CameraFile> given = givenCamera(options.camera);
  const bool by_name = given && !given->camera.intrinsics.valid();
  const bool of_map = isMapFile(options.camera);
  if (pipe_) {
    openFrames(pipe_);
  } else if (V4l2Frames::reads(options.device)) {
    openFrames(std::make_shared<V4l2Frames>(options.device, given.value_or(CameraFile())));
  } else {
    if (!by_name) camera_ = given;
    if (camera_ && !camera_->isPinhole()) lens_camera_ = camera_;
    openDevice(options);
    if (by_name) useNoiseOf(given->camera);
  }
  if (of_map) camera_ = cameraOfMap(options.camera, camera_);
}

void LiveSource::useNoiseOf(const Camera& usual) {
  if (!camera_) camera_.emplace();  // without intrinsics, which frames tell
  camera_->camera.noise = usual.noise;
  camera_->camera.max_depth = usual.max_depth;
}

/** Frames of which the camera is known with the first one. */
void LiveSource::openFrames(std::shared_ptr<FrameSource> frames) {
  name_ = frames->name();
  const auto camera = frames->camera(kFirstFrame);
  if (!camera)
    throw IoError(name_, frames->atEnd() ? "ended without a frame"
                                         : fmt::format("no frame for {} s", kFirstFrame.count()));
  camera_ = *camera;
  auto grabber = std::make_unique<FrameGrabber>(std::move(frames));
  frames_ = grabber.get();
  grabber_ = std::move(grabber);
}

void LiveSource::openDevice(const LiveSourceOptions& options) {
  const fs::path folder = options.device;
  if (!camera_ && fs::is_directory(folder))
    for (const fs::path& place : {folder, folder.parent_path()})
      if (!camera_ && fs::exists(place / "camera.ini")) camera_ = readCameraFile(place / "camera.ini");
  auto device = std::make_unique<OpenNIGrabber>(options.device);
  device->setPlayback(options.speed, options.repeat);
  device_ = device.get();
  if (every_frame_ && !device->isFile())
    throw std::runtime_error(device->uri() + " is a camera, whose frames cannot wait: --every-frame is for "
                                             "recordings");
  calibration_ = calibrationOf(*device);
  if (!camera_ && calibration_ && device->mounting())
    camera_ = CameraFile{{*calibration_, {}, device->mounting(), {}}};
  grabber_ = std::move(device);
  if (name_.empty()) name_ = device_->uri();
}

LiveSource::~LiveSource() { stop(); }

void LiveSource::start(const FrameSink& sink) {
  if (player_) return player_->start(sink);
  std::optional<Intrinsics> intrinsics = calibration_;
  if (camera_ && camera_->camera.intrinsics.valid()) intrinsics = camera_->camera.intrinsics;
  connectFrames(*grabber_, intrinsics, lens_camera_ ? corrected(*lens_camera_, sink) : sink);
  next();
  grabber_->start();
}

void LiveSource::stop() { player_ ? player_->stop() : grabber_->stop(); }

void LiveSource::next() {
  if (!every_frame_) return;
  if (player_)
    player_->next();
  else if (device_)
    device_->trigger(1);
  else if (frames_)
    frames_->trigger(1);
}

bool LiveSource::isFile() const {
  if (frames_) return !frames_->source().isLive();
  return !device_ || device_->isFile();
}

Findings LiveSource::findings() const {
  if (player_) return player_->findings();
  Findings found;
  if (camera_)
    if (auto optics = opticsFinding(camera_->camera.intrinsics)) found.push_back(std::move(*optics));
  return found;
}

bool LiveSource::atEnd() const {
  if (player_) return player_->atEnd();
  if (device_) return device_->isEndOfFile();
  return frames_->atEnd();
}

bool LiveSource::connected() const {
  if (frames_) return frames_->lastError().empty();
  return !device_ || device_->isConnected();
}

std::string LiveSource::lastError() const {
  if (player_) return player_->lastError();
  if (device_) return device_->lastError();
  return frames_->lastError();
}

}  // namespace facetloc
