// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/ros_messages.h"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

namespace facetloc::internal {
namespace {

/** CDR2, D_CDR2 and PL_CDR2 of OMG's DDS-XTypes 7.6.3.1.2, of both byte orders. */
bool isXcdr2(const std::uint8_t* kind) { return kind[0] == 0 && kind[1] >= 6 && kind[1] <= 11; }

/** Without the slash in front, as tf once had it. */
std::string readFrame(MessageReader& message) {
  std::string frame = message.text();
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
}

}  // namespace

MessageReader::MessageReader(ByteView bytes, WireFormat format)
    : data_(bytes.data), size_(bytes.size), format_(format) {
  if (format == WireFormat::other) throw BadMessage("is of an encoding that is not read");
  if (format != WireFormat::cdr) return;
  constexpr std::size_t kEncapsulation = 4;
  constexpr int kBigEndian = 0, kLittleEndian = 1;
  const std::uint8_t* kind = take(kEncapsulation);
  if (kind[0] != 0 || kind[1] > kLittleEndian)
    throw BadMessage(fmt::format(
        "is not encoded as plain CDR (XCDR1) but by representation 0x{:02x}{:02x}{}", kind[0], kind[1],
        isXcdr2(kind)
            ? ", XCDR2: play it (ros2 bag play), and record it by a middleware that writes XCDR1, which "
              "is the default of rmw_fastrtps_cpp"
            : ""));
  swapped_ = kind[1] == kBigEndian;
  data_ += kEncapsulation, size_ -= kEncapsulation, next_ = 0;  // alignment counts from here
}

void MessageReader::ends() { throw BadMessage("ends before its last field"); }

std::string MessageReader::text() {
  const ByteView text = bytes();
  const std::string_view words(reinterpret_cast<const char*>(text.data), text.size);
  return std::string(words.substr(0, words.find('\0')));  // CDR counts the terminating zero
}

ByteView MessageReader::bytes() {
  const auto size = number<std::uint32_t>();
  return {take(size), size};
}

std::vector<double> MessageReader::reals() {
  const auto size = number<std::uint32_t>();
  if (size > left() / sizeof(double)) ends();
  std::vector<double> values(size);
  for (double& value : values) value = number<double>();
  return values;
}

MessageHeader readHeader(MessageReader& message) {
  MessageHeader header;
  if (message.format() == WireFormat::ros1) {
    message.skip<std::uint32_t>(1);  // the counter
    header.stamp = message.number<std::uint32_t>();
  } else {
    header.stamp = message.number<std::int32_t>();
  }
  header.stamp += kNanosecond * message.number<std::uint32_t>();
  header.frame = readFrame(message);
  return header;
}

ImageMessage ImageMessage::read(MessageReader& message) {
  return {readHeader(message), message.number<std::uint32_t>(),     message.number<std::uint32_t>(),
          message.text(),      message.number<std::uint8_t>() != 0, message.number<std::uint32_t>(),
          message.bytes()};
}

CompressedImageMessage CompressedImageMessage::read(MessageReader& message) {
  return {readHeader(message), message.text(), message.bytes()};
}

CameraInfoMessage CameraInfoMessage::read(MessageReader& message) {
  CameraInfoMessage info{readHeader(message),
                         message.number<std::uint32_t>(),
                         message.number<std::uint32_t>(),
                         message.text(),
                         message.reals(),
                         message.reals<9>()};
  message.skip<double>(9);  // R, of a stereo camera's rectification
  info.P = message.reals<12>();
  if (message.atEnd()) return info;  // as some writers end it
  for (std::uint32_t& side : info.binning) side = std::max(message.number<std::uint32_t>(), 1u);
  for (std::uint32_t& side : info.roi) side = message.number<std::uint32_t>();
  return info;
}

bool CameraInfoMessage::isReduced() const {
  return binning[0] > 1 || binning[1] > 1 || (roi[2] > 0 && roi[2] < height) ||
         (roi[3] > 0 && roi[3] < width);
}

CameraInfoMessage CameraInfoMessage::ofImage() const {
  CameraInfoMessage info = *this;
  const auto [x, y, rows, columns] = roi;
  info.width = (columns > 0 ? columns : width) / binning[0];
  info.height = (rows > 0 ? rows : height) / binning[1];
  const auto reduce = [this](std::uint32_t offset, std::size_t axis, double& f, double& c) {
    f /= binning[axis];
    c = (c - offset) / binning[axis];
  };
  reduce(x, 0, info.K[0], info.K[2]), reduce(y, 1, info.K[4], info.K[5]);
  reduce(x, 0, info.P[0], info.P[2]), reduce(y, 1, info.P[5], info.P[6]);
  return info;
}

OdometryMessage OdometryMessage::read(MessageReader& message) {
  OdometryMessage odometry{{readHeader(message), message.text(), message.reals<7>()}};
  message.skip<double>(36 + 6 + 36);  // covariances and twist, which a message that is cut off lacks
  return odometry;
}

TransformsMessage TransformsMessage::read(MessageReader& message) {
  TransformsMessage tf;
  for (auto n = message.number<std::uint32_t>(); n > 0; --n)
    tf.transforms.push_back({readHeader(message), readFrame(message), message.reals<7>()});
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
