// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "devices/z16_buffers.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/error.h>
#include <facetloc/io/v4l2_frames.h>

#include <fmt/format.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using internal::Z16Layout;

constexpr const char* kFileEnding = ".z16";

bool isFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

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
  if (isFile(device) && !size.valid())
    if (const CameraPreset* preset = findCameraPreset(camera.preset)) size = preset->intrinsics();
  buffers_ = isFile(device) ? internal::openZ16File(device, size.width, size.height)
                            : internal::openZ16Device(device, size.width, size.height);
  camera_ = std::make_shared<CameraFile>(fitted(camera, buffers_->layout(), name_));
}

V4l2Frames::~V4l2Frames() = default;

bool V4l2Frames::reads(const fs::path& path) {
  std::error_code ignored;
  return fs::is_character_file(path, ignored) || (isFile(path) && path.extension() == kFileEnding);
}

bool V4l2Frames::atEnd() const { return buffers_->atEnd(); }
bool V4l2Frames::isLive() const { return buffers_->isLive(); }

DepthFrame::ConstPtr V4l2Frames::next(Patience patience) {
  auto frame = std::make_shared<DepthFrame>();
  const Z16Layout layout = buffers_->layout();
  const auto read = [&](const internal::Z16Buffer& buffer) {
    frame->number = ++frames_;
    frame->stamp = buffer.stamp;
    frame->camera = camera_;
    if (buffer.size < layout.bytes())
      throw IoError(name_, fmt::format("frame {}: is torn: it has {} bytes of {}", frames_, buffer.size,
                                       layout.bytes()));
    frame->values = internal::depthsOf(buffer.bytes, layout);
  };
  if (!buffers_->take(patience, read)) return {};
  return frame;
}

}  // namespace facetloc
