// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/ros_messages.h"

#include <algorithm>
#include <iterator>

namespace facetloc::internal {
namespace {

template <std::size_t N>
void readReals(MessageReader& message, std::array<double, N>& values) {
  for (double& value : values) value = message.number<double>();
}

}  // namespace

MessageHeader readHeader(MessageReader& message) {
  constexpr double kNanosecond = 1e-9;
  MessageHeader header;
  if (message.format() == WireFormat::ros1) {
    message.skip<std::uint32_t>(1);  // the counter
    header.stamp = message.number<std::uint32_t>();
  } else {
    header.stamp = message.number<std::int32_t>();
  }
  header.stamp += kNanosecond * message.number<std::uint32_t>();
  header.frame = message.text();
  if (!header.frame.empty() && header.frame.front() == '/') header.frame.erase(0, 1);  // as tf once had it
  return header;
}

ImageMessage ImageMessage::read(MessageReader& message) {
  ImageMessage image;
  image.header = readHeader(message);
  image.height = message.number<std::uint32_t>();
  image.width = message.number<std::uint32_t>();
  image.encoding = message.text();
  image.big_endian = message.number<std::uint8_t>() != 0;
  image.step = message.number<std::uint32_t>();
  image.data = message.bytes();
  return image;
}

CompressedImageMessage CompressedImageMessage::read(MessageReader& message) {
  CompressedImageMessage image;
  image.header = readHeader(message);
  image.format = message.text();
  image.data = message.bytes();
  return image;
}

CameraInfoMessage CameraInfoMessage::read(MessageReader& message) {
  CameraInfoMessage info;
  info.header = readHeader(message);
  info.height = message.number<std::uint32_t>();
  info.width = message.number<std::uint32_t>();
  info.distortion_model = message.text();
  info.D = message.reals();
  readReals(message, info.K);
  message.skip<double>(9);  // R, of a stereo camera's rectification
  readReals(message, info.P);
  return info;
}

OdometryMessage OdometryMessage::read(MessageReader& message) {
  OdometryMessage odometry;
  odometry.header = readHeader(message);
  odometry.child_frame = message.text();
  readReals(message, odometry.pose);
  message.skip<double>(36 + 6 + 36);  // covariances and twist, which a message that is cut off lacks
  return odometry;
}

TransformsMessage TransformsMessage::read(MessageReader& message) {
  TransformsMessage tf;
  for (auto n = message.number<std::uint32_t>(); n > 0; --n) {
    TransformMessage transform;
    transform.header = readHeader(message);
    transform.child_frame = message.text();
    if (!transform.child_frame.empty() && transform.child_frame.front() == '/')
      transform.child_frame.erase(0, 1);
    readReals(message, transform.pose);
    tf.transforms.push_back(std::move(transform));
  }
  return tf;
}

ImuMessage ImuMessage::read(MessageReader& message) {
  constexpr double kNotMeasured = -1;  // as the first covariance, by the definition of the message
  constexpr double kLargest = 1e4;     // [m/s^2] beyond the range of any accelerometer
  ImuMessage imu;
  imu.header = readHeader(message);
  message.skip<double>(4 + 9 + 3 + 9);  // orientation and angular velocity, with covariances
  for (int k = 0; k < 3; ++k) imu.acceleration[k] = message.number<double>();
  imu.has_acceleration = message.number<double>() != kNotMeasured && imu.acceleration.allFinite() &&
                         imu.acceleration.cwiseAbs().maxCoeff() <= kLargest &&
                         imu.acceleration.squaredNorm() > 0;
  return imu;
}

FloatMessage FloatMessage::read(MessageReader& message) { return {message.number<float>()}; }

std::string typeWithoutMsg(const std::string& type) {
  constexpr const char* kMsg = "/msg/";
  const auto at = type.find(kMsg);
  return at == std::string::npos ? type : type.substr(0, at) + type.substr(at + 4);
}

bool isKnownType(const std::string& type) {
  const char* known[] = {ImageMessage::kType,    CompressedImageMessage::kType, CameraInfoMessage::kType,
                         OdometryMessage::kType, TransformsMessage::kType,      ImuMessage::kType,
                         FloatMessage::kType};
  return std::any_of(std::begin(known), std::end(known), [&type](const char* t) { return type == t; });
}

}  // namespace facetloc::internal
