// SPDX-License-Identifier: BSD-3-Clause
#include "tools/map_build_checks.h"

#include "cli/text.h"
#include "inputs/depth_input.h"
#include "tools/image_trajectory.h"

#include <facetloc/io/depth_values.h>
#include <facetloc/io/error.h>

#include <fmt/format.h>

namespace facetloc {

std::size_t MapBuildChecks::withoutPose(const MapMaking& making) const {
  std::size_t without = 0;
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) without += !making.pose(i);
  return without;
}

void MapBuildChecks::checkReading(MapMaking& making) const {
  const auto tell = [&](const std::string& fault, bool impossible) {
    if (impossible && !force)
      throw IoError(recording,
                    "cannot be right as it is read: " + fault + "; --force builds the map nevertheless");
    console.note(fault);
  };
  if (!canBeReadAgain(sequence)) return;
  if (sequence.camera()) {
    const ValueCheck values = checkValues(depthValues(sequence), sequence.camera()->depth_scale);
    for (const std::string& fault : values.faults) tell(fault, values.impossible);
    const Intrinsics& optics = sequence.camera()->camera.intrinsics;
    if (const std::string fault = opticsFault(optics); !fault.empty()) tell(fault, true);
  }
  making.checkGeometry();
  for (const ReadingFault& fault : making.findings().geometry->faults) tell(fault.words, fault.impossible);
}

std::string MapBuildChecks::checkPoses(MapMaking& making) const {
  if (given.empty() || !sequence.stamped() || !canBeReadAgain(sequence)) return {};
  making.checkPoses();
  const PoseCheck& check = *making.findings().poses;
  if (!check.isKnown()) return {};
  if (!check.cause.empty()) {
    const std::string mended = check.mended.toString(), as_given = check.as_given.toString();
    console.note(fmt::format("the poses disagree with the images by {}; {}{}", as_given, check.cause,
                             mended == as_given ? "" : "; so read, they disagree by " + mended) +
                 adviceOnPoses(check));
  }
  if (check.isBeyondSense() && !force)
    throw IoError(
        poses.empty() ? recording : poses,
        fmt::format("its poses are not those of its images: they disagree by {}{}; --force builds the map "
                    "nevertheless",
                    check.as_given.toString(),
                    check.cause.empty() ? "; look at fx, fy and depth_scale of camera.ini, too" : ""));
  return check.as_given.toString();
}

void MapBuildChecks::noteWithoutPose(const MapMaking& making) const {
  if (making.findings().trajectory) return;
  const std::size_t without = withoutPose(making);
  if (without > 0)
    console.note(fmt::format("{} without a pose within {:.9g} s", counted(without, "image"), pose_tolerance));
}

void MapBuildChecks::requireMostPosed(const MapMaking& making) const {
  if (given.empty() || force) return;
  const std::size_t all = sequence.frames().size();
  const std::size_t without = withoutPose(making);
  if (2 * without <= all || without == all) return;
  throw IoError(
      poses.empty() ? recording : poses,
      fmt::format("{} of {} have no pose within {:.9g} s, and the others show too few motions to check their "
                  "poses by: are the times of images and poses those of one clock (--time-offset)? Is "
                  "--pose-tolerance too small? --force builds the map nevertheless",
                  without, counted(all, "image"), pose_tolerance));
}

void MapBuildChecks::noteTrajectory(const CameraTrajectory& trajectory) const {
  console.out << "trajectory: " << toString(trajectory) << "; " << trajectory.overlaps.toString() << "\n";
  if (trajectory.cut_bonds > 0)
    console.note(
        fmt::format("{} between pieces of the trajectory taken out, which overlapping images contradict",
                    counted(static_cast<std::size_t>(trajectory.cut_bonds), "bond")));
  const std::vector<int> parts = trajectory.parts();
  if (parts.size() < 2) return;
  std::size_t outside = 0;
  for (const TrajectoryPose& pose : trajectory.images)
    outside += trajectory.partOf(pose) != parts.front();
  console.note(fmt::format("the images are not all connected: {} in {} that nothing ties to the largest one; "
                           "their local models have no pose in its world",
                           counted(outside, "image"), counted(parts.size() - 1, "piece")));
}

void MapBuildChecks::noteDistortion(const MapFindings& findings) const {
  const auto& found = findings.distortion;
  if (!found || found->reliable()) return;
  if (findings.trajectory) {
    console.note(fmt::format("the distortion of the camera is not estimated: the trajectory is accurate to "
                             "{:.2f} deg, {:.0f} mm only",
                             found->poses.rotation_std / kDegree, 1e3 * found->poses.translation_std));
    return;
  }
  console.note(fmt::format(
      "the distortion of the camera is not removed: the poses disagree too much with the images ({:.2f} deg, "
      "{:.0f} mm) to find it",
      found->poses.rotation_std / kDegree, 1e3 * found->poses.translation_std));
}

}  // namespace facetloc
