// SPDX-License-Identifier: BSD-3-Clause
#include "depth_device.h"

#include "depth_stream.h"
#include "properties.h"

#include <facetloc/io/virtual_camera.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace facetloc {

DepthDevice::DepthDevice(std::unique_ptr<FrameSource> source, std::function<void(int)> report)
    : playback_(std::make_shared<Playback>(std::move(source))),
      report_(std::move(report)),
      mode_(modeOf(playback_->source())),
      sensor_{ONI_SENSOR_DEPTH, 1, &mode_} {}

OniStatus DepthDevice::getSensorInfoList(OniSensorInfo** sensors, int* count) {
  *sensors = &sensor_;
  *count = 1;
  return ONI_STATUS_OK;
}

oni::driver::StreamBase* DepthDevice::createStream(OniSensorType type) {
  if (type != ONI_SENSOR_DEPTH || has_stream_) return nullptr;
  has_stream_ = true;
  return new DepthStream(playback_, report_);
}

void DepthDevice::destroyStream(oni::driver::StreamBase* stream) {
  delete stream;
  has_stream_ = false;
}

OniBool DepthDevice::isPropertySupported(int id) {
  switch (id) {
  case ONI_DEVICE_PROPERTY_DRIVER_VERSION:
  case ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION:
  case ONI_DEVICE_PROPERTY_PLAYBACK_SPEED:
  case ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED:
  case kVirtualCameraTrigger:
  case kVirtualCameraError:
  case kVirtualCameraIntrinsics:
    return TRUE;
  case kVirtualCameraMounting:
    return playback_->source().mounting() ? TRUE : FALSE;
  default:
    return FALSE;
  }
}

OniStatus DepthDevice::getProperty(int id, void* data, int* size) {
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

OniStatus DepthDevice::setProperty(int id, const void* data, int size) {
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

OniStatus DepthDevice::invoke(int command, void* data, int size) {
  if (command != ONI_DEVICE_COMMAND_SEEK) return ONI_STATUS_NOT_IMPLEMENTED;
  const auto seek = takeProperty<OniSeek>(data, size);
  if (!seek || seek->frameIndex < 0) return ONI_STATUS_BAD_PARAMETER;
  playback_->seek(static_cast<std::size_t>(std::max(seek->frameIndex, 1) - 1));  // the first frame is 1
  return ONI_STATUS_OK;
}

}  // namespace facetloc
