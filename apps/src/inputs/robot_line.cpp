// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/robot_line.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <json/json.h>
#include <memory>

namespace facetloc {
namespace {

template <int N>
Eigen::Matrix<double, N, 1> numbersOf(const Json::Value& pose, const char* key) {
  const Json::Value& list = pose[key];
  if (!list.isArray() || list.size() != static_cast<Json::ArrayIndex>(N))
    throw std::invalid_argument(fmt::format("its {} must have {} numbers", key, N));
  Eigen::Matrix<double, N, 1> numbers;
  for (Json::ArrayIndex i = 0; i < list.size(); ++i) {
    if (!list[i].isNumeric()) throw std::invalid_argument(fmt::format("its {} must consist of numbers", key));
    numbers[static_cast<Eigen::Index>(i)] = list[i].asDouble();
  }
  if (!numbers.allFinite()) throw std::invalid_argument(fmt::format("its {} is not finite", key));
  return numbers;
}

Eigen::Isometry3d poseOf(const Json::Value& pose) {
  constexpr double kUnit = 1e-2;  // largest error of the length of a rounded quaternion
  if (!pose.isObject())
    throw std::invalid_argument("its pose must be an object with position and quaternion");
  const Eigen::Quaterniond q(numbersOf<4>(pose, "quaternion"));
  if (!(std::abs(q.norm() - 1) < kUnit)) throw std::invalid_argument("its quaternion is no rotation");
  Eigen::Isometry3d T(q.normalized());
  T.translation() = numbersOf<3>(pose, "position");
  return T;
}

/** T_a_c, of T_w_c or T_w_b. */
Eigen::Isometry3d cameraPoseOf(const Json::Value& value, const std::optional<CameraMounting>& mounting) {
  if (const Json::Value& camera = value["T_w_c"]; !camera.isNull()) return poseOf(camera);
  const Json::Value& base = value["T_w_b"];
  if (base.isNull()) throw std::invalid_argument("it has neither T_w_b nor T_w_c");
  if (!mounting)
    throw std::invalid_argument("T_w_b needs the mounting of the camera on the robot, in its camera.ini");
  return poseOf(base) * mounting->T_b_c();
}

OdometryLine odometryOf(const Json::Value& value, const std::optional<CameraMounting>& mounting) {
  OdometryLine odometry;
  const Json::Value& stamp = value["stamp"];
  if (!stamp.isNull()) {
    if (!stamp.isNumeric() || !std::isfinite(stamp.asDouble()))
      throw std::invalid_argument("its stamp must be a number");
    odometry.stamp = stamp.asDouble();
  }
  odometry.T_o_c = cameraPoseOf(value, mounting);
  return odometry;
}

/** The upper triangle by rows, as the stream has it. */
Matrix6d covarianceOf(const Json::Value& value) {
  const Eigen::Matrix<double, 21, 1> upper = numbersOf<21>(value, "covariance");
  Matrix6d P;
  Eigen::Index k = 0;
  for (int row = 0; row < 6; ++row)
    for (int col = row; col < 6; ++col) P(row, col) = P(col, row) = upper[k++];
  if (Eigen::LLT<Matrix6d>(P).info() != Eigen::Success)
    throw std::invalid_argument("its covariance is not positive definite");
  return P;
}

StartLine startOf(const Json::Value& value, const std::optional<CameraMounting>& mounting) {
  constexpr double kUsualStd = 1, kUsualStdDeg = 30;  // as of --near
  if (!value.isObject()) throw std::invalid_argument("it must be an object with T_w_c or T_w_b");
  StartLine start;
  start.T_w_c.T = cameraPoseOf(value, mounting);
  start.T_w_c.P =
      value["covariance"].isNull() ? startCovariance(kUsualStd, kUsualStdDeg * kDegree) : covarianceOf(value);
  if (const Json::Value& part = value["part"]; !part.isNull()) {
    if (!part.isString()) throw std::invalid_argument("its part must be a string");
    start.part = part.asString();
  }
  return start;
}

}  // namespace

Json::Value jsonOf(const std::string& line) {
  Json::CharReaderBuilder builder;
  Json::CharReaderBuilder::strictMode(&builder.settings_);
  const std::unique_ptr<Json::CharReader> reader(builder.newCharReader());
  Json::Value value;
  std::string errors;
  bool is_json = false;
  try {
    is_json = reader->parse(line.data(), line.data() + line.size(), &value, &errors);
  } catch (const std::exception&) {  // nested too deeply
  }
  if (!is_json || !value.isObject()) throw std::invalid_argument("it is no JSON object");
  return value;
}

Matrix6d startCovariance(double std_m, double std_rad) {
  Matrix6d P = Matrix6d::Zero();
  constexpr double kMostTilt = 30 * kDegree;  // a camera whose heading is open is upright all the same
  const double tilt = std::min(std_rad, kMostTilt);
  P.diagonal() << tilt * tilt, tilt * tilt, std_rad * std_rad, Eigen::Vector3d::Constant(std_m * std_m);
  return P;
}

RobotLine parseRobotLine(const std::string& line, const std::optional<CameraMounting>& mounting) {
  const Json::Value value = jsonOf(line);
  RobotLine out;
  if (value.isMember("pose")) {
    try {
      out.start = startOf(value["pose"], mounting);
    } catch (const std::invalid_argument& e) {
      throw RobotCommandError(std::string("its pose cannot be used: ") + e.what());
    }
  } else if (value.isMember("relocalize")) {
    if (!value["relocalize"].isBool()) throw RobotCommandError("its relocalize is neither true nor false");
    out.relocalize = value["relocalize"].asBool();
  } else {
    out.odometry = odometryOf(value, mounting);
  }
  return out;
}

OdometryLine parseOdometry(const std::string& line, const std::optional<CameraMounting>& mounting) {
  return odometryOf(jsonOf(line), mounting);
}

}  // namespace facetloc
