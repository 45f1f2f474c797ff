// SPDX-License-Identifier: BSD-3-Clause
#include "tools/image_trajectory.h"

#include "base/text.h"
#include "cli/text.h"
#include "inputs/robot_line.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <filesystem>
#include <fmt/core.h>
#include <fstream>
#include <memory>
#include <stdexcept>

namespace facetloc {
namespace {

/** Does it begin as an object of JSON does? */
bool holdsJson(const std::string& file) {
  std::ifstream in(file);
  char first = 0;
  while (in >> first && (first == 0 || (first & 0x80) != 0)) {  // bytes of a mark
  }
  return first == '{';
}

std::vector<StampedPose> readLines(const std::string& file, const std::optional<CameraMounting>& mounting) {
  const std::string content = readText(file);
  std::vector<StampedPose> poses;
  int number = 0;
  for (const std::string_view line : text::lines(content)) {
    ++number;
    if (text::trimmed(line).empty()) continue;
    try {
      const OdometryLine odometry = parseOdometry(std::string(line), mounting);
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
  console.note(remark);
  if (mounting)
    for (StampedPose& pose : poses) pose.T_w_c = pose.T_w_c * mounting->T_b_c();
  return poses;
}

}  // namespace

std::string toString(const CameraTrajectory& trajectory) {
  return fmt::format("way {:.1f} m, known to {:.2f} m and {:.1f} deg, {}, {} with places seen before, {}",
                     trajectory.length(), trajectory.positionStd(), trajectory.rotationStd() / kDegree,
                     counted(trajectory.keyframes.size(), "keyframe"),
                     counted(static_cast<std::size_t>(trajectory.loops()), "comparison"),
                     counted(trajectory.parts().size(), "piece"));
}

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

void ImageTrajectory::addOptions(CommandLine& line) {
  line.addOption("odometry", odometry_, "FILE",
                 "Odometry: poses that drift, such as those of wheels (ROBOT.md).");
  line.addParams(params_, "mapping");
}

std::string ImageTrajectory::toIni() const {
  return (odometry_.empty() ? "" : fmt::format("odometry = {}\n", odometry_)) +
         facetloc::toIni(params_, "mapping");
}

PosesByTime ImageTrajectory::odometry(const DepthSequence& sequence, const Camera& camera,
                                      const Console& console) const {
  return odometryByTime(odometry_, sequence, camera.mounting, console);
}

int ImageTrajectory::report(const MapFindings& findings, const DepthSequence& sequence,
                            const Console& console) const {
  for (const UnreadImage& image : findings.unread) console.error(image.cause);
  const int code = findings.unread.empty() ? kOk : kFailed;
  if (findings.noneRead(sequence.frames().size()))
    throw IoError(sequence.frames().front().path.parent_path(), "none of its images can be read");
  if (findings.without_odometry > 0)
    console.note(counted(findings.without_odometry, "image") + " outside the time of the odometry");
  if (!findings.odometry || !findings.odometry->isKnown()) return code;
  const PoseCheck& check = *findings.odometry;
  console.note(fmt::format("odometry and images disagree by {}{}", check.as_given.toString(),
                           check.cause.empty() ? "" : "; " + check.cause));
  if (check.wrong_convention) throw IoError(odometry_, "is not of these images as it stands; " + check.cause);
  return code;
}

}  // namespace facetloc
