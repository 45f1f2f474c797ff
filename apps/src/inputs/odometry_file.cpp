// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/odometry_file.h"

#include "base/text.h"
#include "inputs/robot_line.h"

#include <facetloc/io/error.h>

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <vector>

namespace facetloc {
namespace {

/** Does it begin as an object of JSON does? */
bool holdsJson(const std::string& file) {
  std::ifstream in(file);
  char first = 0;
  return in >> first && first == '{';
}

std::vector<StampedPose> readLines(const std::string& file, const std::optional<CameraMounting>& mounting) {
  std::ifstream in(file);
  if (!in) throw IoError(file, "cannot be opened");
  std::vector<StampedPose> poses;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (text::trimmed(line).empty()) continue;
    try {
      const OdometryLine odometry = parseOdometry(line, mounting);
      if (!odometry.stamp)
        throw std::invalid_argument("it has no stamp, which odometry of a recording needs");
      poses.push_back({*odometry.stamp, odometry.T_o_c});
    } catch (const std::invalid_argument& e) {
      throw IoError(file, fmt::format("line {} is no odometry: {}", number, e.what()));
    }
  }
  return poses;
}

std::vector<StampedPose> readPoses(const std::string& file, const DepthSequence& sequence,
                                   const std::optional<CameraMounting>& mounting, const Console& console) {
  std::string remark;
  std::vector<StampedPose> poses = sequence.readOdometry(file, &remark).poses();
  if (!remark.empty()) console.note(remark);
  if (mounting)
    for (StampedPose& pose : poses) pose.T_w_c = pose.T_w_c * mounting->T_b_c();
  return poses;
}

}  // namespace

PosesByTime odometryByTime(const std::string& file, const DepthSequence& sequence,
                           const std::optional<CameraMounting>& mounting, const Console& console) {
  if (file.empty()) return {};
  if (!sequence.stamped())
    throw IoError(file, "the image names are no time stamps: an odometry cannot be matched with them");
  const bool is_json = std::filesystem::is_regular_file(file) && holdsJson(file);
  std::vector<StampedPose> poses =
      is_json ? readLines(file, mounting) : readPoses(file, sequence, mounting, console);
  if (poses.empty()) throw IoError(file, "has no poses");
  return [trajectory = std::make_shared<const Trajectory>(std::move(poses))](double stamp) {
    return trajectory->interpolated(stamp);
  };
}

}  // namespace facetloc
