// SPDX-License-Identifier: BSD-3-Clause
// Video4Linux2, by the kernel's header alone.
#include "base/text.h"
#include "bytes/files.h"
#include "bytes/temporary_file.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/v4l2_frames.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

namespace facetloc {

namespace internal {

/** Layout of an image in a buffer: rows of width 16-bit values, little-endian, with bytes_per_row from
 * one to the next. */
struct Z16Layout {
  int width = 0, height = 0;
  std::size_t bytes_per_row = 0;

  /** Bytes from the first of the first row to the last of the last one. */
  std::size_t bytes() const {
    return bytes_per_row * static_cast<std::size_t>(height - 1) + 2 * static_cast<std::size_t>(width);
  }
};

/** Who fills buffers of Z16: a driver of the kernel, or a file. */
class Z16Buffers {
public:
  explicit Z16Buffers(const fs::path& path) : name_(path.string()) {}
  virtual ~Z16Buffers() = default;
  const Z16Layout& layout() const { return layout_; }
  /** Makes a frame of the next buffer. \return false if none was filled in time, or none will be. Throws
   * IoError. */
  virtual bool take(FrameSource::Patience patience, DepthFrame& frame) = 0;
  virtual bool atEnd() const = 0;
  virtual bool isLive() const = 0;

protected:
  /** Throws IoError for a buffer of less than layout_.bytes(). \param stamp [s] */
  void unpack(const unsigned char* bytes, std::size_t size, double stamp, DepthFrame& frame) {
    frame.number = ++frames_;
    frame.stamp = stamp;
    if (size < layout_.bytes())
      throw IoError(name_,
                    fmt::format("frame {}: is torn: it has {} bytes of {}", frames_, size, layout_.bytes()));
    const auto width = static_cast<std::size_t>(layout_.width),
               height = static_cast<std::size_t>(layout_.height);
    frame.values.resize(width * height);
    for (std::size_t row = 0; row < height; ++row)  // both little-endian
      std::memcpy(frame.values.data() + row * width, bytes + row * layout_.bytes_per_row, 2 * width);
  }

  const std::string name_;
  Z16Layout layout_;
  std::uint64_t frames_ = 0;
};

namespace {

constexpr unsigned kBuffers = 4;

struct Unmap {
  std::size_t size = 0;
  void operator()(void* start) const { ::munmap(start, size); }
};
/** A buffer of the driver in our memory. */
using Mapped = std::unique_ptr<void, Unmap>;

std::string nameOf(std::uint32_t format) {
  std::string name;
  for (int shift = 0; shift < 32; shift += 8) {
    const char c = static_cast<char>(format >> shift & 0x7f);
    name += c >= ' ' && c <= '~' ? c : '?';
  }
  return name;
}

class Z16Device : public Z16Buffers {
public:
  /** \param width, height to ask the driver for; 0 = as it is set */
  Z16Device(const fs::path& path, int width, int height)
      : Z16Buffers(path), file_(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)) {
    if (!file_) throw IoError(name_, "cannot be opened: " + files::lastError());
    requireCapture();
    setFormat(width, height);
    mapBuffers();
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    control(VIDIOC_STREAMON, &type, "does not start");
  }
  ~Z16Device() override {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request(VIDIOC_STREAMOFF, &type);
  }

  bool atEnd() const override { return false; }
  bool isLive() const override { return true; }

  bool take(FrameSource::Patience patience, DepthFrame& frame) override {
    pollfd waits{file_.number(), POLLIN, 0};
    if (::poll(&waits, 1, static_cast<int>(patience.count())) <= 0) return false;
    v4l2_buffer buffer = bufferNumber(0);
    if (request(VIDIOC_DQBUF, &buffer) != 0) {
      if (errno == EAGAIN) return false;
      throw IoError(name_, "has gone: " + files::lastError());
    }
    const bool sound = !(buffer.flags & V4L2_BUF_FLAG_ERROR) && buffer.index < mapped_.size();
    if (sound) {
      const Mapped& memory = mapped_[buffer.index];
      unpack(static_cast<const unsigned char*>(memory.get()),
             std::min<std::size_t>(buffer.bytesused, memory.get_deleter().size),
             static_cast<double>(buffer.timestamp.tv_sec) +
                 1e-6 * static_cast<double>(buffer.timestamp.tv_usec),
             frame);
    }
    control(VIDIOC_QBUF, &buffer, "takes no buffer back");
    return sound;
  }

private:
  int request(unsigned long what, void* argument) const {
    int result = 0;
    do result = ::ioctl(file_.number(), what, argument);
    while (result != 0 && errno == EINTR);
    return result;
  }
  void control(unsigned long what, void* argument, const char* otherwise) const {
    if (request(what, argument) != 0)
      throw IoError(name_, fmt::format("{}: {}", otherwise, files::lastError()));
  }
  static v4l2_buffer bufferNumber(unsigned index) {
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    return buffer;
  }

  void requireCapture() const {
    v4l2_capability can{};
    control(VIDIOC_QUERYCAP, &can, "is no video device");
    const std::uint32_t caps = can.capabilities & V4L2_CAP_DEVICE_CAPS ? can.device_caps : can.capabilities;
    if (!(caps & V4L2_CAP_VIDEO_CAPTURE) || !(caps & V4L2_CAP_STREAMING))
      throw IoError(name_, "sends no images: a camera has several video devices, of which one has its depth");
  }

  std::string formats() const {
    std::string names;
    v4l2_fmtdesc format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    for (; request(VIDIOC_ENUM_FMT, &format) == 0; ++format.index)
      names += (names.empty() ? "" : ", ") + nameOf(format.pixelformat);
    return names.empty() ? "nothing" : names;
  }

  void setFormat(int width, int height) {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    control(VIDIOC_G_FMT, &format, "has no format");
    v4l2_pix_format& image = format.fmt.pix;
    if (width > 0)
      image.width = static_cast<std::uint32_t>(width), image.height = static_cast<std::uint32_t>(height);
    image.pixelformat = V4L2_PIX_FMT_Z16;
    image.bytesperline = 0;
    control(VIDIOC_S_FMT, &format, "refuses depth (Z16)");
    if (image.pixelformat != V4L2_PIX_FMT_Z16)
      throw IoError(name_, fmt::format("sends {}, but no depth (Z16): a camera has several video devices, of "
                                       "which one has its depth",
                                       formats()));
    constexpr std::uint32_t kLargestSide = 1 << 14;
    if (image.width < 1 || image.height < 1 || image.width > kLargestSide || image.height > kLargestSide)
      throw IoError(name_,
                    fmt::format("sends images of {}x{}, which is impossible", image.width, image.height));
    layout_ = {static_cast<int>(image.width), static_cast<int>(image.height),
               std::max<std::size_t>(image.bytesperline, 2 * std::size_t(image.width))};
  }

  void mapBuffers() {
    v4l2_requestbuffers wanted{};
    wanted.count = kBuffers;
    wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    wanted.memory = V4L2_MEMORY_MMAP;
    control(VIDIOC_REQBUFS, &wanted, "has no buffers (is another program using it?)");
    for (unsigned i = 0; i < wanted.count; ++i) {
      v4l2_buffer buffer = bufferNumber(i);
      control(VIDIOC_QUERYBUF, &buffer, "does not show its buffers");
      void* start =
          ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, file_.number(), buffer.m.offset);
      if (start == MAP_FAILED) throw IoError(name_, "cannot be mapped: " + files::lastError());
      mapped_.emplace_back(start, Unmap{buffer.length});
      control(VIDIOC_QBUF, &buffer, "takes no buffer");
    }
  }

  const files::Descriptor file_;
  std::vector<Mapped> mapped_;
};

constexpr double kUsualInterval = 1.0 / 30;  // [s]

/** Frames without gaps between rows or frames. */
class Z16File : public Z16Buffers {
public:
  Z16File(const fs::path& path, int width, int height) : Z16Buffers(path) {
    layout_ = {width, height, 2 * static_cast<std::size_t>(width)};
    files::requireRegularFile(path);
    if (width <= 0 || height <= 0)
      throw IoError(name_, "does not say how large its images are: give a camera.ini");
    in_.open(path, std::ios::binary);
    if (!in_) throw IoError(name_, "cannot be opened: " + files::lastError());
    if (fs::file_size(path) == 0) throw IoError(name_, "is empty");
  }

  bool atEnd() const override { return ended_; }
  bool isLive() const override { return false; }

  bool take(FrameSource::Patience, DepthFrame& frame) override {
    bytes_.resize(layout_.bytes());
    in_.read(reinterpret_cast<char*>(bytes_.data()), static_cast<std::streamsize>(bytes_.size()));
    const auto n = static_cast<std::size_t>(in_.gcount());
    ended_ = n == 0;
    if (!ended_) unpack(bytes_.data(), n, kUsualInterval * static_cast<double>(frames_), frame);
    ended_ = ended_ || in_.peek() == std::ifstream::traits_type::eof();
    return n > 0;
  }

private:
  std::ifstream in_;
  std::vector<unsigned char> bytes_;
  bool ended_ = false;
};

}  // namespace
}  // namespace internal

namespace {

using internal::Z16Layout;

constexpr const char* kFileEnding = ".z16";

/** The camera with intrinsics of the images that the device sends. */
CameraFile fitted(CameraFile camera, const Z16Layout& layout, const std::string& name) {
  Intrinsics& k = camera.camera.intrinsics;
  if (k.valid()) {
    if (k.width == layout.width && k.height == layout.height) return camera;
    throw IoError(name, fmt::format("sends images of {}x{}, not of the {}x{} of the camera that is given",
                                    layout.width, layout.height, k.width, k.height));
  }
  const CameraPreset* preset = findCameraPreset(camera.preset);
  const auto typical = preset ? preset->intrinsicsOf(layout.width, layout.height) : std::nullopt;
  if (!typical)
    throw IoError(name, fmt::format("does not name its camera, which sends images of {}x{}: give a "
                                    "camera.ini, or the name of a camera that has such images",
                                    layout.width, layout.height));
  k = *typical;
  return camera;
}

}  // namespace

V4l2Frames::V4l2Frames(const fs::path& device, const CameraFile& camera) : name_(device.string()) {
  Intrinsics size = camera.camera.intrinsics;
  if (files::isFile(device) && !size.valid())
    if (const CameraPreset* preset = findCameraPreset(camera.preset)) size = preset->intrinsics();
  if (files::isFile(device))
    buffers_ = std::make_unique<internal::Z16File>(device, size.width, size.height);
  else
    buffers_ = std::make_unique<internal::Z16Device>(device, size.width, size.height);
  camera_ = std::make_shared<CameraFile>(fitted(camera, buffers_->layout(), name_));
}

V4l2Frames::~V4l2Frames() = default;

bool V4l2Frames::reads(const fs::path& path) {
  std::error_code ignored;
  return fs::is_character_file(path, ignored) ||
         (files::isFile(path) && text::lowerExtension(path) == kFileEnding);
}

bool V4l2Frames::atEnd() const { return buffers_->atEnd(); }
bool V4l2Frames::isLive() const { return buffers_->isLive(); }

DepthFrame::ConstPtr V4l2Frames::next(Patience patience) {
  auto frame = std::make_shared<DepthFrame>();
  frame->camera = camera_;
  if (!buffers_->take(patience, *frame)) return {};
  return frame;
}

}  // namespace facetloc
