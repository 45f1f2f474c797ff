// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera_presets.h>
#include <facetloc/simulation/simulated_camera.h>

#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

/** Noise of depth of the devices. \return default-constructed for Kinect and Xtion, which are twins */
DepthNoise noiseOf(std::string_view name) {
  DepthNoise noise;
  if (name == "realsense_d435") noise.inverse_depth_std = 0.0030;
  if (name == "azure_kinect")
    noise.inverse_depth_std = 0.0001, noise.depth_std = noise.depth_std_slope = 0.0005;
  if (name == "phone_lidar")
    noise.inverse_depth_std = 0.0001, noise.depth_std = noise.depth_std_slope = 0.002;
  return noise;
}

/** Neither a pattern nor steps of disparity: the common errors of all cameras but a Kinect. */
SimulatedNoise plain(const CameraPreset& preset) {
  const DepthNoise of_depth = noiseOf(preset.name);
  SimulatedNoise noise;
  noise.disparity_std = of_depth.inverse_depth_std * kKinectGain;
  noise.depth_std = of_depth.depth_std;
  noise.depth_std_slope = of_depth.depth_std_slope;
  noise.quantization = 0;
  noise.min_depth = 0.3;
  noise.max_depth = 8;
  return noise;
}

SimulatedNoise stereo(const CameraPreset& preset) {
  SimulatedNoise noise = plain(preset);
  noise.correlation_px = 5;  // a wall is wavy: the correlation falls to 1/e over 10 px
  noise.fattening_px = 4;
  noise.untextured = 0.15;
  noise.projector_baseline = 0.05;  // hides surfaces from the second camera
  noise.dark_range = 0;
  return noise;
}

SimulatedNoise timeOfFlight(const CameraPreset& preset) {
  SimulatedNoise noise = plain(preset);
  noise.correlation_px = 0;
  noise.flying_px = 1;
  noise.multipath = 0.015;
  noise.projector_baseline = 0;
  noise.max_depth = preset.max_depth;
  return noise;
}

/** Few beams, of which the system makes an image without holes: smooth, also over silhouettes. */
SimulatedNoise filledUp(const CameraPreset& preset) {
  SimulatedNoise noise = plain(preset);
  noise.correlation_px = 6;
  noise.flying_px = 3;
  noise.random_dropout = 0;
  noise.projector_baseline = 0;
  noise.dark_range = 0;
  noise.grazing_dropout_deg = 90;
  noise.grazing_spread_deg = 0;
  noise.reliable_depth = preset.max_depth;
  return noise;
}

SimulatedNoise rough(const CameraPreset& preset) {
  const std::string_view name = preset.name;
  if (name == "realsense_d435") return stereo(preset);
  if (name == "azure_kinect") return timeOfFlight(preset);
  if (name == "phone_lidar") return filledUp(preset);
  return {};  // Kinect and Xtion are twins
}

void addSharedErrors(std::string_view name, SimulatedNoise& noise) {
  noise.smooth_error = 0.003;  // left by a calibration, and due to temperature
  if (name == "realsense_d435") {
    noise.smooth_error = 0.005;
    noise.blur_px = 3;
  } else if (name == "azure_kinect") {
    noise.smooth_error = 0.002;
  } else if (name == "phone_lidar") {
    noise.smooth_error = 0.004;
    noise.blur_px = 8;
    noise.filling_px = 10;  // half the distance of neighbouring beams
  }
}

}  // namespace

SimulatedNoise simulatedNoise(std::string_view name, SharedErrors shared) {
  const CameraPreset* preset = findCameraPreset(name);
  if (!preset) throw std::invalid_argument("simulatedNoise: unknown camera " + std::string(name));
  SimulatedNoise noise = rough(*preset);
  if (shared == SharedErrors::as_measured) addSharedErrors(name, noise);
  return noise;
}

}  // namespace facetloc
