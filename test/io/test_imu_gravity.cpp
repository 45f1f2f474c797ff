// SPDX-License-Identifier: BSD-3-Clause
// The accelerometer of a camera that is shaken, turned and pushed, in messages of ROS 1 in an MCAP.
#include "recordings/image_container.h"
#include "recordings/message_file.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace facetloc::internal {
namespace {

using test::putBytes;
using test::TemporaryFolder;

constexpr double kG = 9.81, kRate = 200;
constexpr const char* kFrame = "camera";

template <typename T>
std::string raw(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}
std::string text(const std::string& words) { return raw(static_cast<std::uint32_t>(words.size())) + words; }
std::string record(char opcode, const std::string& content) {
  return opcode + raw(static_cast<std::uint64_t>(content.size())) + content;
}

/** Ten seconds of an IMU. \param acceleration its measurement at a time [m/s^2] */
std::string mcapOf(const std::function<Eigen::Vector3d(double)>& acceleration) {
  std::string file = "\x89MCAP0\r\n" + record(1, text("") + text(""));
  file += record(3, raw<std::uint16_t>(1) + text("sensor_msgs/Imu") + text("ros1msg") + text(""));
  file += record(4, raw<std::uint16_t>(1) + raw<std::uint16_t>(1) + text("/imu") + text("ros1") + text(""));
  for (int i = 0; i < 10 * kRate; ++i) {
    const double stamp = i / kRate;
    const auto seconds = static_cast<std::uint32_t>(stamp);
    const auto nanoseconds = static_cast<std::uint32_t>(std::lround(1e9 * (stamp - seconds)));
    const Eigen::Vector3d a = acceleration(stamp);
    std::string message = raw(std::uint32_t(i)) + raw(seconds) + raw(nanoseconds) + text(kFrame);
    message += std::string(25 * sizeof(double), '\0') + raw(a.x()) + raw(a.y()) + raw(a.z());
    message += std::string(9 * sizeof(double), '\0');
    const std::uint64_t written = std::uint64_t(i) * 5000000;
    file += record(5, raw<std::uint16_t>(1) + raw(std::uint32_t(i)) + raw(written) + raw(written) + message);
  }
  return file + record(15, raw(std::uint32_t(0)));
}

GravityRecord gravityOf(const std::function<Eigen::Vector3d(double)>& acceleration,
                        const std::vector<double>& stamps) {
  const TemporaryFolder folder;
  const MessageLog log(putBytes(folder / "walk.mcap", mcapOf(acceleration)));
  return readImuGravity(log, kFrame, stamps, kDegree).gravity;
}

double error(const GravityRecord& gravity, double stamp, const Eigen::Vector3d& down) {
  return std::acos(std::min(1.0, gravity.at(stamp)->down.dot(down)));
}

const Eigen::Vector3d kUp(0, -kG, 0);  // measured at rest, in the optical frame

TEST(ImuGravity, ShakingIsAveragedOut) {
  const auto shaken = [](double t) {
    return Eigen::Vector3d(kUp + Eigen::Vector3d(2, 1, 2) * std::sin(4 * M_PI * t));  // steps of a walk, 2 Hz
  };
  const GravityRecord gravity = gravityOf(shaken, {3, 5, 7.3});
  for (const double stamp : {3.0, 5.0, 7.3}) {
    EXPECT_LT(error(gravity, stamp, Eigen::Vector3d::UnitY()), 0.2 * kDegree);
    EXPECT_NEAR(gravity.at(stamp)->std, kDegree, 0.1 * kDegree);
  }
}

TEST(ImuGravity, ATurningCameraIsNotLaggedBehind) {
  const double rate = 40 * kDegree;  // [rad/s] about the optical axis
  const auto turning = [rate](double t) {
    return Eigen::Vector3d(kG * std::sin(rate * t), -kG * std::cos(rate * t), 0);
  };
  const GravityRecord gravity = gravityOf(turning, {2, 5});
  for (const double t : {2.0, 5.0})
    EXPECT_LT(error(gravity, t, {-std::sin(rate * t), std::cos(rate * t), 0}), 0.2 * kDegree);
}

TEST(ImuGravity, BrokenMessagesAreLeftOut) {
  for (const double broken : {1e300, -1e20, 1e9}) {
    const auto once = [broken](double t) {
      return std::abs(t - 2) < 0.008 ? Eigen::Vector3d(broken, 0, broken) : kUp;
    };
    const GravityRecord gravity = gravityOf(once, {1, 2, 5, 8});
    for (const double stamp : {1.0, 2.0, 5.0, 8.0}) {
      ASSERT_TRUE(gravity.at(stamp)) << broken << " at " << stamp;
      EXPECT_LT(error(gravity, stamp, Eigen::Vector3d::UnitY()), 1e-6);
    }
  }
}

TEST(ImuGravity, APushMakesItLessSureOrLeavesItOut) {
  const auto pushed = [](double t) {
    const double push = t > 4.4 && t < 5.6 ? 1.0 : t > 7.4 && t < 8.6 ? 4.0 : 0.0;
    return Eigen::Vector3d(kUp - Eigen::Vector3d(0, push, 0));
  };
  const GravityRecord gravity = gravityOf(pushed, {1, 2, 3, 5, 8});
  EXPECT_NEAR(gravity.at(2)->std, kDegree, 1e-6);
  EXPECT_NEAR(gravity.at(5)->std, std::hypot(kDegree, 1.0 / kG), 1e-3);
  EXPECT_FALSE(gravity.at(8)) << "pushed by 40 % of gravity";
}

}  // namespace
}  // namespace facetloc::internal
