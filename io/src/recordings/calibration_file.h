// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/lens_distortion.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace facetloc::internal {

/** \brief A calibration of a depth camera. */
struct Calibration {
  Intrinsics intrinsics;  ///< width and height are 0 where the file does not say them
  LensDistortion lens;
  std::optional<double> depth_scale{};  ///< image values per metre
  bool of_scanner = false;              ///< depth images show the same view with other numbers of pixels
};

/** \brief A calibration of ROS (camera_info), OpenCV (FileStorage, as RTAB-Map's), Kalibr (pinhole),
 * ORB-SLAM, Open3D, Replica, NeRF (transforms.json) or scanner apps of phones: matrices or fx, fy, cx, cy,
 * with the distortion of a pinhole camera's lens. Empty if the text has no intrinsics. Of several cameras the
 * first. Throws IoError for a lens of another model. \param source named in errors */
std::optional<Calibration> parseCalibration(std::string_view text, const std::string& source);

/** \brief The lens of the coefficients k1 k2 p1 p2 [k3 [k4 k5 k6]], as ROS and OpenCV have them, by the name
 * of their model: empty, plumb_bob, radtan, rational_polynomial and the like. Throws std::invalid_argument
 * with a sentence for other models, unless all coefficients are zero, and for numbers that are not finite. */
LensDistortion lensOf(const std::string& model, const std::vector<double>& coefficients);

}  // namespace facetloc::internal
