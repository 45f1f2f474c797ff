// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/pose.h>

#include <json/forwards.h>
#include <optional>
#include <stdexcept>
#include <string>

namespace facetloc {

/** \brief A pose that an odometry tells, in a frame of its own, which may drift. */
struct OdometryLine {
  std::optional<double> stamp;  ///< [s]; none = now
  Eigen::Isometry3d T_o_c = Eigen::Isometry3d::Identity();
};

/** \brief Where a robot says that its camera is. */
struct StartLine {
  PoseWithCovariance T_w_c;
  std::string part;  ///< name of the part of the map whose frame the pose is in; empty: the world
};

/** \brief The content of one line from a robot: one of these. */
struct RobotLine {
  std::optional<OdometryLine> odometry;
  std::optional<StartLine> start;
  bool relocalize = false;
};

/** \brief A line that is a command, and cannot be obeyed. */
class RobotCommandError : public std::invalid_argument {
public:
  using std::invalid_argument::invalid_argument;
};

/** \brief Reads a line in the form of the stream (ROBOT.md): an odometry, T_w_c, or T_w_b with the mounting,
 * and stamp; {"pose": {...}} with a pose in the map, as a line of the stream has it; or {"relocalize": true}.
 * Other members do not matter. Throws RobotCommandError with the cause for the last two, and
 * std::invalid_argument for any other line. */
RobotLine parseRobotLine(const std::string& line, const std::optional<CameraMounting>& mounting);

/** \brief Reads a line that has to be odometry. Throws std::invalid_argument with the cause. */
OdometryLine parseOdometry(const std::string& line, const std::optional<CameraMounting>& mounting);

/** \brief A line that is an object of JSON. Throws std::invalid_argument for any other. */
Json::Value jsonOf(const std::string& line);

/** \brief Covariance of a start of which no more is known than its standard deviations [m, rad]. */
Matrix6d startCovariance(double std_m, double std_rad);

}  // namespace facetloc
