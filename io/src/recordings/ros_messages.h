// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/message_reader.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/** \file
 * The messages of ROS 1 and ROS 2 that recordings are read from. Their fields are the same but for the
 * header, which has a counter in ROS 1 only. Each is read from the beginning of a message; all throw
 * BadMessage. Views of bytes point into the message. Private to io. */

namespace facetloc::internal {

/** \brief std_msgs/Header. */
struct MessageHeader {
  double stamp = 0;  ///< [s]
  std::string frame{};
};
MessageHeader readHeader(MessageReader& message);

/** \brief sensor_msgs/Image. */
struct ImageMessage {
  static constexpr const char* kType = "sensor_msgs/Image";
  MessageHeader header;
  std::uint32_t height = 0, width = 0;
  std::string encoding;
  bool big_endian = false;
  std::uint32_t step = 0;  ///< bytes of a row
  ByteView data;
  static ImageMessage read(MessageReader& message);
};

/** \brief sensor_msgs/CompressedImage. */
struct CompressedImageMessage {
  static constexpr const char* kType = "sensor_msgs/CompressedImage";
  MessageHeader header;
  std::string format;
  ByteView data;
  static CompressedImageMessage read(MessageReader& message);
};

/** \brief sensor_msgs/CameraInfo, up to its matrices. */
struct CameraInfoMessage {
  static constexpr const char* kType = "sensor_msgs/CameraInfo";
  MessageHeader header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> D;
  std::array<double, 9> K{};
  std::array<double, 12> P{};
  static CameraInfoMessage read(MessageReader& message);
};

/** \brief nav_msgs/Odometry, without covariances and velocities. */
struct OdometryMessage {
  static constexpr const char* kType = "nav_msgs/Odometry";
  MessageHeader header;
  std::string child_frame;
  std::array<double, 7> pose{};  ///< tx ty tz qx qy qz qw of the child frame in the frame of the header
  static OdometryMessage read(MessageReader& message);
};

/** \brief geometry_msgs/TransformStamped. */
struct TransformMessage {
  MessageHeader header;
  std::string child_frame;
  std::array<double, 7> pose{};  ///< tx ty tz qx qy qz qw of the child frame in the frame of the header
};
/** \brief tf2_msgs/TFMessage. */
struct TransformsMessage {
  static constexpr const char* kType = "tf2_msgs/TFMessage";
  std::vector<TransformMessage> transforms;
  static TransformsMessage read(MessageReader& message);
};

/** \brief sensor_msgs/Imu, the part of the accelerometer. */
struct ImuMessage {
  static constexpr const char* kType = "sensor_msgs/Imu";
  MessageHeader header;
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< [m/s^2], of a thing at rest upwards
  bool has_acceleration = false;
  static ImuMessage read(MessageReader& message);
};

/** \brief std_msgs/Float32. */
struct FloatMessage {
  static constexpr const char* kType = "std_msgs/Float32";
  float value = 0;
  static FloatMessage read(MessageReader& message);
};

/** \brief "sensor_msgs/Image" of sensor_msgs/msg/Image. */
std::string typeWithoutMsg(const std::string& type);
/** \brief Is it one of the types above? */
bool isKnownType(const std::string& type);

}  // namespace facetloc::internal
