// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

/** \file
 * The messages of ROS 1 and ROS 2 that recordings are read from. Their fields are the same but for the
 * header, which has a counter in ROS 1 only. Each is read from the beginning of a message; all throw
 * BadMessage. Views of bytes point into the message. Private to io. */

namespace facetloc::internal {

using Bytes = std::vector<std::uint8_t>;
constexpr double kNanosecond = 1e-9;  ///< [s]

/** \brief Bytes that somebody else owns. */
struct ByteView {
  ByteView() = default;
  ByteView(const std::uint8_t* begin, std::size_t n) : data(begin), size(n) {}
  ByteView(const Bytes& bytes) : data(bytes.data()), size(bytes.size()) {}

  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
};

/** \brief How messages are serialized. */
enum class WireFormat {
  ros1,   ///< ROS 1: packed, little-endian
  cdr,    ///< ROS 2: XCDR1 of OMG's DDS-XTypes 7.4, behind the 4 bytes that name its byte order
  other,  ///< not read here
};

/** \brief A message that does not fit its type. The text continues "its message ...". */
class BadMessage : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/** \brief Reads the fields of one message in their order, in either format. Total on any bytes: it throws
 * BadMessage rather than read beyond the end, and allocates no more than the message has bytes. */
class MessageReader {
public:
  /** \brief Throws BadMessage for CDR with parameter lists, XCDR2, or without an encapsulation. */
  MessageReader(ByteView bytes, WireFormat format);

  WireFormat format() const { return format_; }
  bool atEnd() const { return next_ == size_; }

  template <typename Number>
  Number number() {
    static_assert(std::is_arithmetic_v<Number>);
    align(sizeof(Number));
    std::uint8_t raw[sizeof(Number)];
    std::memcpy(raw, take(sizeof raw), sizeof raw);
    if (swapped_)
      for (std::size_t i = 0; i < sizeof raw / 2; ++i) std::swap(raw[i], raw[sizeof raw - 1 - i]);
    Number value;
    std::memcpy(&value, raw, sizeof value);
    return value;
  }
  std::string text();
  /** \brief A sequence of bytes, which stay where they are. */
  ByteView bytes();
  /** \brief A sequence of doubles. */
  std::vector<double> reals();
  /** \brief Doubles of a fixed number. */
  template <std::size_t N>
  std::array<double, N> reals() {
    std::array<double, N> values;
    for (double& value : values) value = number<double>();
    return values;
  }
  /** \brief Passes over n numbers of a type. */
  template <typename Number>
  void skip(std::size_t n) {
    if (n == 0) return;
    align(sizeof(Number));
    if (n > left() / sizeof(Number)) ends();
    next_ += n * sizeof(Number);
  }

private:
  [[noreturn]] static void ends();
  std::size_t left() const { return size_ - next_; }
  const std::uint8_t* take(std::size_t n) {
    if (n > left()) ends();
    const std::uint8_t* at = data_ + next_;
    next_ += n;
    return at;
  }
  /** A number of CDR begins at a multiple of its size. */
  void align(std::size_t size) {
    if (format_ == WireFormat::cdr) take((size - next_ % size) % size);
  }

  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t next_ = 0;
  WireFormat format_;
  bool swapped_ = false;  // the message is big-endian
};

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

/** \brief sensor_msgs/CameraInfo. */
struct CameraInfoMessage {
  static constexpr const char* kType = "sensor_msgs/CameraInfo";
  MessageHeader header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> D;
  std::array<double, 9> K{};
  std::array<double, 12> P{};
  std::array<std::uint32_t, 2> binning{1, 1};  ///< pixels of the sensor per pixel of the image, along x and y
  std::array<std::uint32_t, 4> roi{};          ///< x, y, height, width of the images on the sensor; 0 = all
  static CameraInfoMessage read(MessageReader& message);

  /** \brief Does the image have fewer pixels than the sensor, to which width, height, K and P apply? */
  bool isReduced() const;
  /** \brief The same for the pixels of the image alone. */
  CameraInfoMessage ofImage() const;
};

/** \brief geometry_msgs/TransformStamped. */
struct TransformMessage {
  MessageHeader header;
  std::string child_frame;
  std::array<double, 7> pose{};  ///< tx ty tz qx qy qz qw of the child frame in the frame of the header
};
/** \brief nav_msgs/Odometry, without covariances and velocities. */
struct OdometryMessage : TransformMessage {
  static constexpr const char* kType = "nav_msgs/Odometry";
  static OdometryMessage read(MessageReader& message);
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
