// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/recording_run.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <exception>
#include <filesystem>

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
  return {frame.name, frame.stamp, load, T_w_c, gravity, sequence.timed()};
}

void addImages(const DepthSequence& sequence, const Trajectory& poses, const RunReading& how,
               MapMaking& making) {
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
    const double stamp = sequence.frames()[i].stamp;
    making.add(mapImage(sequence, i, how.working_width, poses.at(stamp, how.pose_tolerance),
                        how.gravity ? how.gravity(stamp) : std::nullopt));
  }
  if (!poses.empty()) making.setPosesByTime([&poses](double stamp) { return poses.interpolated(stamp); });
}

void checkRun(const DepthSequence& sequence, const Findings& read, MapMaking& making, bool in_any_case) {
  const auto isRefused = [&](const Findings& found) {
    return !in_any_case && firstOf(found, Severity::refusal) != nullptr;
  };
  const bool can_be_read_again =  // unlike pipes
      std::all_of(sequence.frames().begin(), sequence.frames().end(),
                  [](const FrameFile& frame) { return std::filesystem::is_regular_file(frame.path); });
  if (isRefused(read) || !can_be_read_again) return;
  making.checkGeometry();
  if (!isRefused(making.findings().list())) making.checkPoses();
}

Findings differenceFindings(const Camera& of_images, const Map& map) {
  Findings found;
  for (const std::string& words : toString(differenceOf(of_images, map.camera), of_images, map.camera))
    found.push_back({"camera.difference", Severity::note, words, ""});
  return found;
}

}  // namespace facetloc
