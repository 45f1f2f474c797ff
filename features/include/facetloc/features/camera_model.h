// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>

namespace facetloc {

/** \name Kinect v1 (METHOD 2.1): z = kKinectGain / (kKinectOffset - d), d the raw disparity in 1/8 px. */
/// @{
constexpr double kKinectGain = 351.218540681877;    ///< [m DU]
constexpr double kKinectOffset = 1092.93080891449;  ///< [DU]
inline double kinectDisparity(double z) { return kKinectOffset - kKinectGain / z; }
inline double kinectDepth(double disparity) { return kKinectGain / (kKinectOffset - disparity); }
/// @}

/** \brief Random error of the depths of a camera, over their range (METHOD 2.2):
 *
 *     sigma_z(z) = depth_std + depth_std_slope z + inverse_depth_std z^2
 *
 * The square is due to triangulation (Kinect, stereo), the rest to the time of flight (ToF,
 * lidar). The default is a Kinect v1. */
struct DepthNoise {
  static constexpr double kLeastInverseDepthStd = 1e-7;  ///< less counts as this: disparities stay finite
  static constexpr double kLargestInverseDepthStd = 1;   ///< [1/m]
  static constexpr double kLargestDepthStd = 1;          ///< [m]
  static constexpr double kLargestDepthStdSlope = 0.5;   ///< [m] per metre of depth
  static constexpr double kUsualDepth = 2;  ///< where one number has to stand for an image or a camera [m]

  double inverse_depth_std = 0.5 / kKinectGain;  ///< part that is the same in inverse depth [1/m]
  double depth_std = 0;                          ///< part that is the same in depth [m]
  double depth_std_slope = 0;                    ///< part that is proportional to depth

  /** \brief Standard deviation of 1/z at depth z > 0 [1/m]. */
  double ofInverseDepth(double z) const { return inverse_depth_std + (depth_std_slope + depth_std / z) / z; }
  /** \brief Standard deviation of z at depth z > 0 [m]. */
  double ofDepth(double z) const { return depth_std + (depth_std_slope + inverse_depth_std * z) * z; }
  /** \brief True if the error of inverse depth is the same at all distances. */
  bool isConstantInInverseDepth() const { return depth_std == 0 && depth_std_slope == 0; }

  /** \brief The noise of an image that has this standard deviation of 1/z [1/m] at depth z: all parts are
   * larger, or smaller, by one factor. */
  DepthNoise scaledTo(double inverse_std, double z) const {
    const double factor = inverse_std / std::max(kLeastInverseDepthStd, ofInverseDepth(z));
    DepthNoise scaled;
    scaled.depth_std = depth_std * factor;
    scaled.depth_std_slope = depth_std_slope * factor;
    // Computed as the remainder, so that the sum is exactly the one required.
    scaled.inverse_depth_std =
        std::max(kLeastInverseDepthStd, inverse_std - (scaled.depth_std_slope + scaled.depth_std / z) / z);
    return scaled;
  }
};

/** \brief Pinhole intrinsics of a depth image [px]; pixel centres are at integer coordinates, fx and fy may
 * differ. */
struct Intrinsics {
  int width = 0;
  int height = 0;
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;

  /** \brief Ray b through a pixel, normalised to b_z = 1; a point of depth z is z b. */
  Eigen::Vector3d ray(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1.0}; }
  /** \brief Pixel of a point in front of the camera (p_z > 0). */
  Eigen::Vector2d project(const Eigen::Vector3d& p) const {
    return {fx * p.x() / p.z() + cx, fy * p.y() / p.z() + cy};
  }
  /** \brief Intrinsics of the image made of every step-th pixel of every step-th row, starting at (0, 0). */
  Intrinsics subsampled(int step) const;
  /** \brief True for a positive size, positive finite focal lengths and a finite centre. */
  bool valid() const;
  bool operator==(const Intrinsics& o) const;
  bool operator!=(const Intrinsics& o) const { return !(*this == o); }
};

/** \brief The depth camera of a Kinect v1, 640x480, as calibrated by the paper's authors. */
Intrinsics kinectIntrinsics();

/** \brief Errors of a depth camera: random noise, and a smooth distortion that is constant in inverse depth.
 *
 * The defaults are those of a Kinect v1 (0.5 DU of noise, a smooth distortion of 0.25 DU plus 0.5 DU per unit
 * of b). camera_presets.h knows other cameras. */
struct SensorNoise : DepthNoise {
  static constexpr const char* kTitle = "Noise of the depth camera";
  static constexpr double kLargestCorrelation = 100;  ///< [px at 320x240]
  double distortion_offset = 0.25 / kKinectGain;
  double distortion_slope = 0.5 / kKinectGain;
  double correlation_px =
      0;  ///< over which pixels share their noise, if it is smooth; 0 = not [px at 320x240]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("inverse_depth_std", p.inverse_depth_std, kLeastInverseDepthStd, 1.0,
          "Random error of inverse depth, standard deviation [1/m]: the part of sigma_z that grows with z^2, "
          "divided by z^2; 0.00142 for a Kinect. Set it for a noisier camera whose noise is smooth over many "
          "pixels.",
          kForUsers);
    visit("distortion_offset", p.distortion_offset, 0.0, 1.0,
          "Smooth distortion of inverse depth at the image centre, standard deviation [1/m].");
    visit("distortion_slope", p.distortion_slope, 0.0, 1.0,
          "Increase of the smooth distortion of inverse depth per unit of the normalised ray, standard "
          "deviation "
          "[1/m].");
    visit("depth_std", p.depth_std, 0.0, kLargestDepthStd,
          "Random error of depth that is equal at all distances, standard deviation [m]; 0 for cameras that "
          "triangulate, about 0.001 for time of flight.",
          kForUsers);
    visit("depth_std_slope", p.depth_std_slope, 0.0, kLargestDepthStdSlope,
          "Random error of depth that grows with depth, standard deviation as a share of depth.", kForUsers);
    visit("correlation_px", p.correlation_px, 0.0, kLargestCorrelation,
          "Minimum correlation length of the noise [px at 320 columns]; 0 = by each image. Each image is "
          "measured, and a smoother one has its own.");
  }
};

/** \brief Covariance of a measured point p [m^2], 3x3, triangulation model in closed form (METHOD
 * 2.3): a pancake of the pixel errors plus an elongated term exactly along the viewing ray. Requires p_z
 * > 0. */
Eigen::Matrix3d pointCovariance(const Eigen::Vector3d& p, const Intrinsics& camera, double pixel_std,
                                double inverse_depth_std);

/** \brief How the camera sits on a robot that drives on a floor: unless set otherwise forward, above the axle
 * and tilted downwards. The floor fixes height, tilt and roll of a pose; the other fields say where the
 * robot is. */
struct CameraMounting {
  double height = 0;    ///< height of the optical centre above the floor [m]
  double tilt_deg = 0;  ///< tilt of the optical axis below the horizon [deg]
  double roll_deg = 0;  ///< about the optical axis: positive if the right side of the image is lower [deg]
  double pan_deg = 0;   ///< angle of the optical axis to the left of straight ahead [deg]
  double x = 0, y = 0;  ///< offset of the optical centre ahead of the base, and to its left [m]

  /** \brief T_b_c: camera optical frame in the robot base (x forward, y left, z up, origin on the floor). */
  Eigen::Isometry3d T_b_c() const;
  /** \brief Does the floor say the same for both, as well as mountings are measured: height to 5 cm, tilt and
   * roll to 5 deg? */
  bool agreesWith(const CameraMounting& other) const;
};

/** \brief How a robot with two drive wheels and a caster stands on an uneven floor. */
struct RobotParams {
  static constexpr const char* kTitle = "Robot on wheels and its floor";
  double floor_std = 0.005;
  double wheel_track = 0.325;
  double caster_distance = 0.165;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("floor_std", p.floor_std, 0.0, 1.0,
          "Unevenness of the floor under each wheel, standard deviation [m].", kForUsers);
    visit("wheel_track", p.wheel_track, 0.01, 10.0, "Distance of the robot's drive wheels [m].", kForUsers);
    visit("caster_distance", p.caster_distance, 0.01, 10.0,
          "Distance of the robot's caster behind the axle of its drive wheels [m].", kForUsers);
  }
};

}  // namespace facetloc
