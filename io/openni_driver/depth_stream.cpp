// SPDX-License-Identifier: BSD-3-Clause
#include "depth_stream.h"

#include "properties.h"

#include <PS1080.h>
#include <cmath>
#include <cstring>
#include <utility>

namespace facetloc {
namespace {

constexpr double kBaseline = 7.5;  // baseline of a Kinect, which the driver simulates [cm]

float fieldOfView(int pixels, double focal_length) {
  return static_cast<float>(2 * std::atan(pixels / (2 * focal_length)));
}

}  // namespace

OniVideoMode modeOf(const FrameSource& source) {
  const Intrinsics& camera = source.camera();
  return {ONI_PIXEL_FORMAT_DEPTH_1_MM, camera.width, camera.height, source.rate()};
}

DepthStream::DepthStream(std::shared_ptr<Playback> playback, std::function<void(int)> report)
    : playback_(std::move(playback)),
      report_(std::move(report)),
      mode_(modeOf(playback_->source())),
      image_(static_cast<std::size_t>(mode_.resolutionX) * mode_.resolutionY) {}

OniStatus DepthStream::start() {
  if (thread_.joinable()) return ONI_STATUS_OK;
  playback_->start();
  thread_ = std::thread([this] { run(); });
  return ONI_STATUS_OK;
}

void DepthStream::stop() {
  playback_->stop();
  if (thread_.joinable()) thread_.join();
}

void DepthStream::run() {
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

void DepthStream::deliver(std::uint64_t stamp) {
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

OniBool DepthStream::isPropertySupported(int id) {
  switch (id) {
  case ONI_STREAM_PROPERTY_VIDEO_MODE:
  case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
  case ONI_STREAM_PROPERTY_VERTICAL_FOV:
  case ONI_STREAM_PROPERTY_STRIDE:
  case ONI_STREAM_PROPERTY_MIRRORING:
  case ONI_STREAM_PROPERTY_CROPPING:
  case ONI_STREAM_PROPERTY_MAX_VALUE:
  case ONI_STREAM_PROPERTY_MIN_VALUE:
  case ONI_STREAM_PROPERTY_NUMBER_OF_FRAMES:
  case XN_STREAM_PROPERTY_EMITTER_DCMOS_DISTANCE:
    return TRUE;
  default:
    return FALSE;
  }
}

OniStatus DepthStream::getProperty(int id, void* data, int* size) {
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
OniStatus DepthStream::setProperty(int id, const void* data, int size) {
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

}  // namespace facetloc
