// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/depth_sequence.h>
#include <facetloc/testing/places.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace facetloc::test {

/** \brief Can bags be written here, by ROS's own library? */
inline bool hasBags() {
  constexpr const char* kTry = "/usr/bin/python3 -c 'import rosbag, nav_msgs.msg, tf2_msgs.msg' 2>/dev/null";
  return std::system(kTry) == 0;  // NOLINT(cert-env33-c)
}

/** \brief Can recordings of ROS 2 and RTAB-Map be written here? */
inline bool hasRecordings() {
  constexpr const char* kTry =
      "/usr/bin/python3 -c 'import ctypes, sqlite3, zlib; ctypes.CDLL(\"libzstd.so.1\"); "
      "ctypes.CDLL(\"liblz4.so.1\")' 2>/dev/null";
  return std::system(kTry) == 0;  // NOLINT(cert-env33-c)
}

/** \brief Calls a script with a sequence, as write_bag.py and write_recording.py read it. \return did it
 * work?
 */
inline bool writeWith(const char* script, const DepthSequence& sequence, const std::filesystem::path& out,
                      const std::string& words, const Trajectory& odometry) {
  namespace fs = std::filesystem;
  const fs::path folder = out.string() + ".raw";
  fs::create_directories(folder);
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
    const DepthImage image = sequence.load(i);
    std::ofstream raw(folder / (sequence.frames()[i].name + ".raw"), std::ios::binary);
    for (const float z : image.depth) {
      const auto value = static_cast<std::uint16_t>(std::lround(1000 * z));
      raw.write(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  const Intrinsics& k = sequence.camera()->camera.intrinsics;
  std::ofstream(folder / "intrinsics.txt")
      << k.width << " " << k.height << " " << k.fx << " " << k.fy << " " << k.cx << " " << k.cy;
  if (!odometry.empty()) writeTumTrajectory(folder / "odometry.txt", odometry.poses());
  const std::string command = std::string("/usr/bin/python3 ") + script + " '" + folder.string() + "' '" +
                              out.string() + "' " + words;
  const bool done = std::system(command.c_str()) == 0;  // NOLINT(cert-env33-c)
  fs::remove_all(folder);
  return done;
}

/** \brief Poses 0.01 s apart from 1000 s on, along a line and turning about the z axis. */
inline std::vector<StampedPose> turningPath(int poses) {
  std::vector<StampedPose> path;
  for (int i = 0; i < poses; ++i) {
    StampedPose pose;
    pose.stamp = 1000 + 0.01 * i;
    pose.T_w_c.translation() << i, 2 * i, 0;
    pose.T_w_c.linear() = Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    path.push_back(pose);
  }
  return path;
}

/** \brief Writes a sequence as a bag (write_bag.py tells the kinds). \return did it work? */
inline bool writeBag(const DepthSequence& sequence, const std::filesystem::path& bag, const std::string& kind,
                     const Trajectory& odometry = {}) {
  return writeWith(kWriteBag, sequence, bag, kind, odometry);
}

/** \brief Writes a sequence as a recording of ROS 2 or RTAB-Map. \param words the container and how it is
 * written (write_recording.py tells them) \return did it work? */
inline bool writeRecording(const DepthSequence& sequence, const std::filesystem::path& out,
                           const std::string& words, const Trajectory& odometry = {}) {
  return writeWith(kWriteRecording, sequence, out, words, odometry);
}

}  // namespace facetloc::test
