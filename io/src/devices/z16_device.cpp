// SPDX-License-Identifier: BSD-3-Clause
// Video4Linux2, by the kernel's header alone.
#include "bytes/files.h"
#include "devices/z16_buffers.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace facetloc::internal {
namespace {

constexpr unsigned kBuffers = 4;

/** A buffer of the driver in our memory. */
struct Mapped {
  void* start = MAP_FAILED;
  std::size_t size = 0;
};

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
  Z16Device(const std::filesystem::path& path, int width, int height) : name_(path.string()) {
    file_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (file_ < 0) throw IoError(name_, "cannot be opened: " + files::lastError());
    try {
      requireCapture();
      setFormat(width, height);
      mapBuffers();
      int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      control(VIDIOC_STREAMON, &type, "does not start");
    } catch (...) {
      close();
      throw;
    }
  }
  ~Z16Device() override { close(); }

  Z16Layout layout() const override { return layout_; }
  bool atEnd() const override { return false; }
  bool isLive() const override { return true; }

  bool take(FrameSource::Patience patience, const std::function<void(const Z16Buffer&)>& use) override {
    pollfd waits{file_, POLLIN, 0};
    if (::poll(&waits, 1, static_cast<int>(patience.count())) <= 0) return false;
    v4l2_buffer buffer = bufferNumber(0);
    if (request(VIDIOC_DQBUF, &buffer) != 0) {
      if (errno == EAGAIN) return false;
      throw IoError(name_, "has gone: " + files::lastError());
    }
    const bool sound = !(buffer.flags & V4L2_BUF_FLAG_ERROR) && buffer.index < mapped_.size();
    if (sound) {
      const Mapped& memory = mapped_[buffer.index];
      use({static_cast<const unsigned char*>(memory.start),
           std::min<std::size_t>(buffer.bytesused, memory.size),
           static_cast<double>(buffer.timestamp.tv_sec) +
               1e-6 * static_cast<double>(buffer.timestamp.tv_usec)});
    }
    control(VIDIOC_QBUF, &buffer, "takes no buffer back");
    return sound;
  }

private:
  int request(unsigned long what, void* argument) const {
    int result = 0;
    do result = ::ioctl(file_, what, argument);
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
      Mapped memory{nullptr, buffer.length};
      memory.start = ::mmap(nullptr, memory.size, PROT_READ | PROT_WRITE, MAP_SHARED, file_, buffer.m.offset);
      if (memory.start == MAP_FAILED) throw IoError(name_, "cannot be mapped: " + files::lastError());
      mapped_.push_back(memory);
      control(VIDIOC_QBUF, &buffer, "takes no buffer");
    }
  }

  void close() {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request(VIDIOC_STREAMOFF, &type);
    for (const Mapped& memory : mapped_) ::munmap(memory.start, memory.size);
    ::close(file_);
  }

  const std::string name_;
  int file_ = -1;
  Z16Layout layout_;
  std::vector<Mapped> mapped_;
};

}  // namespace

std::unique_ptr<Z16Buffers> openZ16Device(const std::filesystem::path& path, int width, int height) {
  return std::make_unique<Z16Device>(path, width, height);
}

}  // namespace facetloc::internal
