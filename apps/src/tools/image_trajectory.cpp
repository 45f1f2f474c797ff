// SPDX-License-Identifier: BSD-3-Clause
#include "tools/image_trajectory.h"

#include "cli/text.h"
#include "inputs/odometry_file.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <fmt/core.h>

namespace facetloc {

MapImage mapImage(const DepthSequence& sequence, std::size_t index, int working_width,
                  const std::optional<Eigen::Isometry3d>& T_w_c, const std::optional<Gravity>& gravity) {
  const FrameFile& frame = sequence.frames()[index];
  const auto load = [&sequence, &frame, index, working_width] {
    try {
      return sequence.load(index, working_width);
    } catch (const IoError&) {
      throw;  // it names the file already
    } catch (const std::exception& e) {
      throw IoError(frame.path.string(), e.what());
    }
  };
  return {frame.name, frame.stamp, load, T_w_c, gravity};
}

bool canBeReadAgain(const DepthSequence& sequence) {
  return std::all_of(sequence.frames().begin(), sequence.frames().end(),
                     [](const FrameFile& frame) { return std::filesystem::is_regular_file(frame.path); });
}

int reportUnread(const MapFindings& findings, const Console& console) {
  for (const UnreadImage& image : findings.unread) console.error(image.cause);
  return findings.unread.empty() ? kOk : kFailed;
}

std::string toString(const CameraTrajectory& trajectory) {
  return fmt::format("way {:.1f} m, {}, {} with places seen before, {}", trajectory.length(),
                     counted(trajectory.keyframes.size(), "keyframe"),
                     counted(static_cast<std::size_t>(trajectory.loops()), "comparison"),
                     counted(trajectory.parts().size(), "piece"));
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
  const int code = reportUnread(findings, console);
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
