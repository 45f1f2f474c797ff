// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/message_camera.h"

#include "base/text.h"
#include "recordings/calibration_file.h"
#include "recordings/image_list.h"

#include <facetloc/features/camera_presets.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace facetloc::internal {
namespace {

constexpr const char* kRealSenseImages = "/image/data";  // ending of the topics of RealSense's recorder
constexpr double kMillimetres = 1000;                    // values per metre

/** /device_0/sensor_0/Depth_0/image/data -> /device_0/sensor_0/option/Depth Units/value. */
void findDepthUnit(const MessageLog& log, CameraFile& camera) {
  for (const MessageTopic& topic : log.topicsOf(FloatMessage::kType)) {
    const std::string name = text::lower(topic.name);
    if (name.find("depth units") == std::string::npos && name.find("depth_units") == std::string::npos)
      continue;
    log.readFirst<FloatMessage>(topic.name, [&camera](const FloatMessage& unit) {
      if (unit.value > 0 && unit.value <= 1) camera.depth_scale = 1 / static_cast<double>(unit.value);
    });
  }
}

/** Images called rectified have no lens. */
void take(const CameraInfoMessage& info, bool called_rectified, MessageCamera& camera) {
  constexpr std::uint32_t kLargestSide = 65535;
  if (info.width > kLargestSide || info.height > kLargestSide) return;
  const int width = static_cast<int>(info.width), height = static_cast<int>(info.height);
  const auto& K = info.K;
  const auto& P = info.P;
  const bool rectified = called_rectified && P[0] > 0;
  camera.file.camera.intrinsics = rectified ? Intrinsics{width, height, P[0], P[5], P[2], P[6]}
                                            : Intrinsics{width, height, K[0], K[4], K[2], K[5]};
  if (rectified) return;
  try {
    camera.file.lens = lensOf(info.distortion_model, info.D);
    if (!camera.file.lens.isNone()) camera.remark = "the lens of its camera_info is taken out of the images";
  } catch (const std::invalid_argument& e) {
    camera.remark = std::string("camera_info: ") + e.what() + "; it is left in the images";
  }
}

/** The topic of another CameraInfo, of the same frame and size; empty if none fits. */
std::string matchingTopic(const MessageLog& log, const ImagesOfTopic& images) {
  if (images.frame.empty() || images.width == 0) return {};
  for (const MessageTopic& topic : log.topicsOf(CameraInfoMessage::kType)) {
    bool matches = false;
    log.readFirst<CameraInfoMessage>(topic.name, [&](const CameraInfoMessage& info) {
      matches =
          info.header.frame == images.frame && info.width == images.width && info.height == images.height;
    });
    if (matches) return topic.name;
  }
  return {};
}

}  // namespace

MessageCamera cameraOfMessages(const MessageLog& log, const ImagesOfTopic& images) {
  const std::string& topic = images.topic;
  const bool is_realsense = endsWith(topic, kRealSenseImages);
  const std::string base = is_realsense
                               ? topic.substr(0, topic.size() - std::strlen(kRealSenseImages)) + "/info"
                               : topic.substr(0, std::min(topic.rfind('/'), topic.size()));
  const CameraPreset& preset = is_realsense ? *findCameraPreset("realsense_d435") : cameraPresets().front();
  MessageCamera camera;
  camera.file.camera = preset.camera();
  camera.file.preset = preset.name;
  camera.file.depth_scale = kMillimetres;
  if (is_realsense) findDepthUnit(log, camera.file);
  const bool called_rectified = text::lower(topic).find("rect") != std::string::npos;
  const auto use = [&](const CameraInfoMessage& info) { take(info, called_rectified, camera); };
  if (log.readFirst<CameraInfoMessage>(base + "/camera_info", use)) return camera;
  const std::string matching = matchingTopic(log, images);
  if (matching.empty()) return camera;
  log.readFirst<CameraInfoMessage>(matching, use);
  camera.remark = fmt::format("their camera is by {}, which has their frame and size{}{}", matching,
                              camera.remark.empty() ? "" : "; ", camera.remark);
  return camera;
}

}  // namespace facetloc::internal
