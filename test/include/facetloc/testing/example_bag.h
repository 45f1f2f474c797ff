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

/** \brief Can bags be written here, by ROS's own library, and does this build read them? */
inline bool hasBags() {
  constexpr const char* kTry = "/usr/bin/python3 -c 'import rosbag, nav_msgs.msg, tf2_msgs.msg' 2>/dev/null";
  return FACETLOC_READS_BAGS && std::system(kTry) == 0;  // NOLINT(cert-env33-c)
}

/** \brief Writes a sequence as a bag (write_bag.py tells the kinds). \return did it work? */
inline bool writeBag(const DepthSequence& sequence, const std::filesystem::path& bag, const std::string& kind,
                     const Trajectory& odometry = {}) {
  namespace fs = std::filesystem;
  const fs::path folder = bag.string() + ".raw";
  fs::create_directories(folder);
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
    const DepthImage image = sequence.load(i);
    std::ofstream out(folder / (sequence.frames()[i].name + ".raw"), std::ios::binary);
    for (const float z : image.depth) {
      const auto value = static_cast<std::uint16_t>(std::lround(1000 * z));
      out.write(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  const Intrinsics& k = sequence.camera()->camera.intrinsics;
  std::ofstream(folder / "intrinsics.txt")
      << k.width << " " << k.height << " " << k.fx << " " << k.fy << " " << k.cx << " " << k.cy;
  if (!odometry.empty()) writeTumTrajectory(folder / "odometry.txt", odometry.poses());
  const std::string command = std::string("/usr/bin/python3 ") + kWriteBag + " '" + folder.string() + "' '" +
                              bag.string() + "' " + kind;
  const bool done = std::system(command.c_str()) == 0;  // NOLINT(cert-env33-c)
  fs::remove_all(folder);
  return done;
}

}  // namespace facetloc::test
