// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera_presets.h>
#include <facetloc/simulation/simulated_camera.h>

#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

/** A projected pattern: Kinect and Xtion are twins. */
SimulatedNoise patterned() {
  SimulatedNoise noise;
  noise.smooth_error = 0.003;  // left by a calibration, and due to temperature
  return noise;
}

/** Neither a pattern nor steps of disparity: the common errors of all cameras but a Kinect.
 * \param inverse_depth_std [1/m] \param depth_std [m], and as a share of depth */
SimulatedNoise plain(double inverse_depth_std, double depth_std) {
  SimulatedNoise noise;
  noise.disparity_std = inverse_depth_std * kKinectGain;
  noise.depth_std = noise.depth_std_slope = depth_std;
  noise.quantization = 0;
  noise.min_depth = 0.3;
  noise.max_depth = 8;
  return noise;
}

SimulatedNoise stereo() {
  SimulatedNoise noise = plain(0.0030, 0);
  noise.correlation_px = 5;  // a wall is wavy: the correlation falls to 1/e over 10 px
  noise.fattening_px = 4;
  noise.untextured = 0.15;
  noise.projector_baseline = 0.05;  // hides surfaces from the second camera
  noise.dark_range = 0;
  noise.smooth_error = 0.005;
  noise.blur_px = 3;
  return noise;
}

SimulatedNoise timeOfFlight(double max_depth) {
  SimulatedNoise noise = plain(0.0001, 0.0005);
  noise.correlation_px = 0;
  noise.flying_px = 1;
  noise.multipath = 0.015;
  noise.projector_baseline = 0;
  noise.max_depth = max_depth;
  noise.smooth_error = 0.002;
  return noise;
}

/** Few beams, of which the system makes an image without holes: smooth, also over silhouettes. */
SimulatedNoise filledUp(double reliable_depth) {
  SimulatedNoise noise = plain(0.0001, 0.002);
  noise.correlation_px = 6;
  noise.flying_px = 3;
  noise.random_dropout = 0;
  noise.projector_baseline = 0;
  noise.dark_range = 0;
  noise.grazing_dropout_deg = 90;
  noise.grazing_spread_deg = 0;
  noise.reliable_depth = reliable_depth;
  noise.smooth_error = 0.004;
  noise.blur_px = 8;
  noise.filling_px = 10;  // half the distance of neighbouring beams
  return noise;
}

}  // namespace

SimulatedNoise simulatedNoise(std::string_view name, SharedErrors shared) {
  const CameraPreset* preset = findCameraPreset(name);
  if (!preset) throw std::invalid_argument("simulatedNoise: unknown camera " + std::string(name));
  SimulatedNoise noise = name == "realsense_d435" ? stereo()
                         : name == "azure_kinect" ? timeOfFlight(preset->max_depth)
                         : name == "phone_lidar"  ? filledUp(preset->max_depth)
                                                  : patterned();
  if (shared == SharedErrors::left_out) noise.smooth_error = noise.blur_px = noise.filling_px = 0;
  return noise;
}

}  // namespace facetloc
