// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera_presets.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/** A device whose optical axis meets the centre of its images. */
Intrinsics centred(int width, int height, double f) {
  return {width, height, f, f, (width - 1) / 2.0, (height - 1) / 2.0};
}

/** The image turned by 90 deg. */
Intrinsics upright(const Intrinsics& k) { return {k.height, k.width, k.fy, k.fx, k.height - 1 - k.cy, k.cx}; }

/** Pixels that are larger or smaller. Nothing for an image of another shape. */
std::optional<Intrinsics> scaledTo(int width, int height, const Intrinsics& k) {
  const double scale = static_cast<double>(width) / k.width;
  if (std::lround(scale * k.height) != height) return {};
  const auto centre = [scale](double c) { return (c + 0.5) * scale - 0.5; };
  return Intrinsics{width, height, scale * k.fx, scale * k.fy, centre(k.cx), centre(k.cy)};
}

}  // namespace

const std::vector<CameraPreset>& cameraPresets() {
  static const std::vector<CameraPreset> presets = {
      {"kinect",
       "Microsoft Kinect v1: structured light, baseline 75 mm",
       {kinectIntrinsics()},
       0.4,
       kNoLimit},
      {"xtion",
       "ASUS Xtion, PrimeSense Carmine: structured light, baseline 75 mm",
       {centred(640, 480, 570.3)},
       0.35,
       kNoLimit},
      {"realsense_d435",
       "Intel RealSense D435: active stereo, baseline 50 mm",
       {centred(640, 480, 385), centred(848, 480, 425), centred(1280, 720, 640), centred(640, 360, 320),
        centred(480, 270, 240), centred(424, 240, 212)},
       0.1,
       6},
      {"azure_kinect",
       "Microsoft Azure Kinect: time of flight",
       {centred(640, 576, 504.5), centred(320, 288, 252), centred(1024, 1024, 504.5), centred(512, 512, 252)},
       0.2,
       5.46},
      {"phone_lidar",
       "Lidar of phones and tablets, as their systems fill it up to 256x192",
       {centred(256, 192, 212)},
       0.1,
       5},
  };
  return presets;
}

const CameraPreset& cameraPresetFor(int width, int height) {
  const auto& presets = cameraPresets();
  for (const CameraPreset& preset : presets)
    if (preset.hasMode(width, height)) return preset;
  for (const CameraPreset& preset : presets)
    if (preset.intrinsicsOf(width, height)) return preset;
  return presets.front();
}

const CameraPreset* findCameraPreset(std::string_view name) {
  const auto& presets = cameraPresets();
  const auto found =
      std::find_if(presets.begin(), presets.end(), [&](const CameraPreset& p) { return p.name == name; });
  return found == presets.end() ? nullptr : &*found;
}

std::string cameraPresetNames() {
  std::string names;
  for (const CameraPreset& preset : cameraPresets())
    names.append(names.empty() ? "" : ", ").append(preset.name);
  return names;
}

Camera CameraPreset::camera() const {
  Camera camera;
  camera.max_depth = max_depth;
  return camera;
}

bool CameraPreset::hasMode(int width, int height) const {
  return std::any_of(modes.begin(), modes.end(), [&](const Intrinsics& mode) {
    return (mode.width == width && mode.height == height) || (mode.width == height && mode.height == width);
  });
}

std::optional<Intrinsics> CameraPreset::intrinsicsOf(int width, int height) const {
  for (const bool only_of_that_size : {true, false})
    for (const bool turned : {false, true})
      for (const Intrinsics& mode : modes) {
        const Intrinsics k = turned ? upright(mode) : mode;
        if (only_of_that_size && k.width != width) continue;
        if (const auto found = scaledTo(width, height, k)) return found;
      }
  return {};
}

}  // namespace facetloc
