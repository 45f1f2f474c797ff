// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/params.h>
#include <facetloc/simulation/simulated_place.h>

#include <cstdint>
#include <string_view>
#include <vector>

namespace facetloc {

/** \brief Errors of the simulated camera: by default those of a structured-light sensor, with the switches of
 * stereo and time-of-flight cameras, which are off. */
struct SimulatedNoise {
  static constexpr const char* kTitle = "Errors of the simulated camera";
  double noise_factor = 1;
  double disparity_std = 0.5;
  double correlation_px = 2.0;
  double distortion = 0.5;
  double quantization = 1.0;
  double random_dropout = 0.005;
  double smooth_error = 0;
  double smooth_images = 10;
  double blur_px = 0;
  double filling_px = 0;

  /** \name The model of a sensor, which a preset sets as a whole */
  /// @{
  double edge_std_px = 0.5;         ///< lateral noise of silhouettes [px]
  double grazing_dropout_deg = 80;  ///< surfaces seen at a larger angle are lost [deg]
  double grazing_spread_deg = 2;    ///< variation of that angle from patch to patch [deg]
  double dark_range = 3.5;  ///< dark surfaces seen at a right angle are lost farther away [m]; 0 = never
  double projector_baseline = 0.075;  ///< distance of camera and projector, which casts shadows [m]
  double min_depth = 0.5;             ///< nearest depth measured [m]
  double max_depth = 8.0;             ///< farthest depth measured [m]
  double depth_std = 0;          ///< part of the random noise of depth that is constant over distance [m]
  double depth_std_slope = 0;    ///< part of the random noise of depth that is a share of depth
  double fattening_px = 0;       ///< stereo: nearer surfaces grow at silhouettes [px at 640x480]
  double untextured = 0;         ///< stereo: share of the pixels that cannot be matched, in patches
  double flying_px = 0;          ///< time of flight: width of mixed depths at silhouettes [px at 640x480]
  double multipath = 0;          ///< time of flight: depths in the edge of a corner are too large by this [m]
  double reliable_depth = 1000;  ///< half of the way beyond it is lost: depths are too small [m]
  /// @}

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("noise_factor", p.noise_factor, 0.0, 20.0,
          "Factor of the random noise, the distortion and the noise of silhouettes.", kForUsers);
    visit("disparity_std", p.disparity_std, 0.0, 20.0, "Random noise of the disparity [1/8 px of a Kinect].");
    visit("correlation_px", p.correlation_px, 0.0, 20.0, "Correlation length of the noise [px]; 0 = white.");
    visit("distortion", p.distortion, 0.0, 20.0,
          "Smooth fixed distortion of the disparity, standard deviation [1/8 px].");
    visit("quantization", p.quantization, 0.0, 20.0, "Step of the disparity [1/8 px]; 0 = none.");
    visit("random_dropout", p.random_dropout, 0.0, 1.0, "Share of pixels lost at random.");
    visit("smooth_error", p.smooth_error, 0.0, 0.5,
          "Smooth error over the whole image, standard deviation as a share of depth.");
    visit("smooth_images", p.smooth_images, 1.0, 1e6,
          "Number of images after which the smooth error is drawn anew.");
    visit("blur_px", p.blur_px, 0.0, 50.0,
          "Radius over which inverse depths are averaged, also across silhouettes, standard deviation [px].");
    visit(
        "filling_px", p.filling_px, 0.0, 50.0,
        "Width beside silhouettes over which depths are interpolated, and holes with them [px]; 0 = never.");
  }
};

/** \brief Errors that neighbouring pixels have in common: smooth ones over the image, blurred or interpolated
 * edges. Real cameras have them; a mean over many pixels is not free of them. */
enum class SharedErrors { left_out, as_measured };

/** \brief The errors of a camera that camera_presets.h knows by this name. Throws std::invalid_argument for
 * another one. */
SimulatedNoise simulatedNoise(std::string_view preset, SharedErrors shared = SharedErrors::left_out);

/** \brief A rendered frame with its truth. */
struct SimulatedFrame {
  DepthImage depth;
  LabelImage labels;  ///< true plane ids, 0 = nothing seen
};

/** \brief Casts rays at a world and adds the errors of a depth camera. Deterministic: the same
 * world, pose, camera and seed give the same image. */
class SimulatedCamera {
public:
  SimulatedCamera(const Intrinsics& camera, const SimulatedNoise& noise, std::uint64_t seed);
  const Intrinsics& camera() const { return camera_; }
  /** \brief Exact depth and labels, without any error of the camera; panes of glass are not there. */
  SimulatedFrame renderExact(const SimulatedWorld& world, const Eigen::Isometry3d& T_w_c) const;
  /** \brief A frame as the sensor sees it; frame_index selects the noise. */
  SimulatedFrame render(const SimulatedWorld& world, const Eigen::Isometry3d& T_w_c,
                        std::uint64_t frame_index) const;

private:
  struct Seen {
    std::vector<double> depth;  // [m], 0 where nothing is seen
    LabelImage labels;
  };
  Seen surfacesSeen(const SimulatedWorld& world, const Eigen::Isometry3d& T_w_c,
                    std::uint64_t frame_index) const;
  void shareErrors(std::vector<double>& depth, std::uint64_t frame_index) const;
  SimulatedFrame measured(const Seen& seen, std::uint64_t frame_index) const;
  double randomStd(double z) const;
  bool reflects(Material material, double z, double cosine, double blob) const;
  std::vector<bool> litByProjector(const std::vector<double>& depth) const;

  Intrinsics camera_;
  SimulatedNoise noise_;
  std::uint64_t seed_;
  std::vector<float> distortion_;  ///< [1/m] per pixel
};

}  // namespace facetloc
