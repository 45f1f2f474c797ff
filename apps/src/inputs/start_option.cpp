// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/localization_options.h"
#include "inputs/robot_line.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace facetloc {

void addStartOption(CommandLine& line, std::string& text) {
  line.addOption("near", text, "X,Y,Z,YAW", "Approximate initial pose [m, deg] (ROBOT.md).");
}

std::optional<PoseWithCovariance> startPose(const std::string& near,
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
