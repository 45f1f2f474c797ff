// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera_presets.h>

#include <algorithm>

namespace facetloc {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/** Noise of a camera whose smooth distortion is as small as a Kinect's. */
SensorNoise noiseOf(double inverse_depth_std, double depth_std, double depth_std_slope) {
  SensorNoise noise;
  noise.inverse_depth_std = inverse_depth_std;
  noise.depth_std = depth_std;
  noise.depth_std_slope = depth_std_slope;
  return noise;
}

}  // namespace

const std::vector<CameraPreset>& cameraPresets() {
  static const std::vector<CameraPreset> presets = {
      {"kinect", "Microsoft Kinect v1: structured light, baseline 75 mm", kinectIntrinsics(), SensorNoise(),
       kNoLimit},
      // The chip of the Kinect with another lens: 0.5 steps of 1/8 px over 8 x 570 px x 75 mm.
      {"xtion",
       "ASUS Xtion, PrimeSense Carmine: structured light, baseline 75 mm",
       {640, 480, 570.3, 570.3, 319.5, 239.5},
       noiseOf(0.00146, 0, 0),
       kNoLimit},
      {"realsense_d435",
       "Intel RealSense D435: active stereo, baseline 50 mm",
       {640, 480, 385.0, 385.0, 319.5, 239.5},
       noiseOf(0.0030, 0, 0),
       6},
      {"azure_kinect",
       "Microsoft Azure Kinect: time of flight, narrow field of view",
       {640, 576, 504.5, 504.5, 319.5, 287.5},
       noiseOf(0.0001, 0.0005, 0.0005),
       5.46},
      {"phone_lidar",
       "Lidar of phones and tablets, as their systems fill it up to 256x192",
       {256, 192, 212.0, 212.0, 127.5, 95.5},
       noiseOf(0.0001, 0.002, 0.002),
       5},
  };
  return presets;
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
  camera.noise = noise;
  camera.max_depth = max_depth;
  return camera;
}

}  // namespace facetloc
