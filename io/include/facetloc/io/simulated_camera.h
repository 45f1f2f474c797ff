// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/params.h>

#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief A one-coloured rectangle of the simulated world: centre, two unit axes and half sizes [m]; seen
 * from both sides. Rectangles of the same plane id are one plane in the true labels. */
struct Rectangle {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_u = Eigen::Vector3d::UnitX();
  Eigen::Vector3d axis_v = Eigen::Vector3d::UnitY();
  double half_u = 1;
  double half_v = 1;
  std::uint16_t plane_id = 1;
};

using Scene = std::vector<Rectangle>;

/** \brief Adds the six faces of a box (centre, orientation, half sizes); plane ids count up from next_id. */
void addBox(Scene& scene, const Eigen::Isometry3d& T_w_box, const Eigen::Vector3d& half_size,
            std::uint16_t& next_id);
/** \brief A closed room of random size with random boxes on its floor and walls, z up, floor at z = 0. The
 * middle, within 0.8 m of the z axis, is free for a camera. Same seed, same room. */
Scene randomRoom(std::uint64_t seed, int boxes = 8);

/** \brief Errors of the simulated camera, those of a structured-light sensor. */
struct SimulatedNoise {
  double disparity_std = 0.5;  ///< random noise of the disparity [DU = 1/8 px of a Kinect]
  double correlation_px =
      1.0;  ///< its correlation length, half width of the matching window [px at 640x480]; 0 = white
  double distortion = 0.5;          ///< smooth, fixed distortion, standard deviation [DU]
  double quantization = 1.0;        ///< of the disparity [DU]; 0 = none
  double edge_std_px = 0.5;         ///< lateral noise of silhouettes [px]
  double grazing_dropout_deg = 80;  ///< surfaces seen at a larger angle are lost [deg]
  double random_dropout = 0.005;    ///< share of pixels lost at random
  double min_depth = 0.5;           ///< [m]
  double max_depth = 8.0;           ///< [m]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("disparity_std", p.disparity_std, 0.0, 20.0, "Random noise of the disparity [1/8 px of a Kinect].");
    field("correlation_px", p.correlation_px, 0.0, 20.0, "Correlation length of the noise [px]; 0 = white.");
    field("distortion", p.distortion, 0.0, 20.0,
          "Smooth fixed distortion of the disparity, standard deviation [1/8 px].");
    field("quantization", p.quantization, 0.0, 20.0, "Step of the disparity [1/8 px]; 0 = none.");
    field("edge_std_px", p.edge_std_px, 0.0, 10.0, "Lateral noise of silhouettes [px].");
    field("grazing_dropout_deg", p.grazing_dropout_deg, 10.0, 90.0,
          "Surfaces seen at a larger angle from their normal are lost [deg].");
    field("random_dropout", p.random_dropout, 0.0, 1.0, "Share of pixels lost at random.");
    field("min_depth", p.min_depth, 0.0, 100.0, "Nearest depth measured [m].");
    field("max_depth", p.max_depth, 0.1, 1000.0, "Farthest depth measured [m].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief A rendered frame with its truth. */
struct SimulatedFrame {
  DepthImage depth;
  LabelImage labels;  ///< true plane ids, 0 = nothing seen
};

/** \brief Casts rays at a world of rectangles and adds the errors of a depth camera. Deterministic: the same
 * scene, pose, camera and seed give the same image. */
class SimulatedCamera {
public:
  SimulatedCamera(const Intrinsics& camera, const SimulatedNoise& noise, std::uint64_t seed);
  const Intrinsics& camera() const { return camera_; }
  /** \brief Exact depth and labels, without any error. */
  SimulatedFrame renderExact(const Scene& scene, const Eigen::Isometry3d& T_w_c) const;
  /** \brief A frame as the sensor sees it; frame_index selects the noise. */
  SimulatedFrame render(const Scene& scene, const Eigen::Isometry3d& T_w_c, std::uint64_t frame_index) const;

private:
  Intrinsics camera_;
  SimulatedNoise noise_;
  std::uint64_t seed_;
  std::vector<float> distortion_;  ///< [1/m] per pixel
};

}  // namespace facetloc
