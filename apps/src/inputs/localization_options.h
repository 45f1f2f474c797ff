// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"
#include "cli/command_line.h"
#include "inputs/robot_line.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/features/pose.h>
#include <facetloc/localization/localization_params.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief The options of localization. Its calibration is known to the command line and to files of
 * parameters, too, but no help offers it. */
inline void addLocalizationOptions(CommandLine& line, GlobalLocalizationParams& params) {
  line.addParams(params);
  line.addParams(params.calibration, "calibration", CommandLine::Shown::nowhere);
}

/** \brief These parameters in the form that results record: a file of parameters. */
inline std::string localizationIni(const GlobalLocalizationParams& params) {
  return toIni(params) + toIni(params.calibration, "calibration");
}

/** \brief The option --map-covers: how much of where the camera goes is in the map. It is a word for
 * --probability.map_incomplete, and does not go with it. */
inline void addMapCovers(CommandLine& line, std::string& share, ProbabilityParams& params) {
  line.addOption("map-covers", share, "SHARE",
                 "Share of where the camera goes that is in the map: all, some, or a number below 1.");
  line.addCheck([&line, &share, &params] {
    if (share.empty()) return;
    if (line.given("probability.map_incomplete"))
      throw UsageError("--map-covers and --probability.map_incomplete say the same; give one of them");
    constexpr double kAll = 0.9;  // doors open, and furniture moves
    const double covered = share == "all"    ? kAll
                           : share == "some" ? 1 - ProbabilityParams{}.map_incomplete
                                             : text::to<double>(share).value_or(-1);
    params.map_incomplete = 1 - covered;
    if (!(covered > 0 && covered < 1))
      throw UsageError("map-covers: '" + share + "' is neither all nor some nor a number between 0 and 1");
  });
}

/** \brief The option --near of tools that follow a camera. */
inline void addStartOption(CommandLine& line, std::string& text) {
  line.addOption("near", text, "X,Y,Z,YAW", "Approximate initial pose [m, deg] (ROBOT.md).");
}

/** \brief The pose of a camera from "x,y,z,yaw_deg[,std_m[,std_deg]]": its position in the world [m], and the
 * direction that it looks in, seen from above, from the x axis counterclockwise. It is tilted and rolled as
 * its mounting says, else level. Nothing for an empty text. Throws UsageError. */
inline std::optional<PoseWithCovariance> startPose(const std::string& near,
                                                   const std::optional<CameraMounting>& mounting) {
  constexpr double kLeastStd = 1e-3, kMostStd = 1e4, kLeastDeg = 0.01;  // [m]
  if (near.empty()) return {};
  std::vector<double> numbers = {0, 0, 0, 0, 1, 30};
  const auto words = text::split(near, ',');
  if (words.size() < 4 || words.size() > numbers.size())
    throw UsageError("near: " + near + " is not x,y,z,yaw_deg[,std_m[,std_deg]]");
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto number = text::to<double>(words[i]);
    if (!number || !std::isfinite(*number))
      throw UsageError("near: '" + std::string(words[i]) + "' is no number");
    numbers[i] = *number;
  }
  const double std_m = numbers[4], std_rad = numbers[5] * kDegree;
  if (!(std_m >= kLeastStd && std_m <= kMostStd && numbers[5] >= kLeastDeg && numbers[5] <= 180))
    throw UsageError("near: standard deviations must be between 1 mm and 10 km, and 0.01 and 180 deg");
  PoseWithCovariance start;
  const CameraMounting mounted = mounting.value_or(CameraMounting{});
  const Eigen::AngleAxisd heading((numbers[3] - mounted.pan_deg) * kDegree, Eigen::Vector3d::UnitZ());
  start.T.linear() = heading.toRotationMatrix() * mounted.T_b_c().linear();
  start.T.translation() << numbers[0], numbers[1], numbers[2];
  start.P = startCovariance(std_m, std_rad);
  return start;
}

}  // namespace facetloc
