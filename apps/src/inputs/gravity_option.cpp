// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/gravity_option.h"

#include "base/text.h"
#include "cli/text.h"

#include <facetloc/io/error.h>

#include <cstdlib>
#include <fmt/core.h>

namespace facetloc {
namespace {

constexpr const char* kIgnored = "none";  // Instead of a file name: ignores gravity in the recording.

}  // namespace

void GravityOption::addOptions(CommandLine& line) {
  line.addOption("gravity", file_, "FILE",
                 "Downward direction of each image (RECORDINGS.md); none = ignore the IMU.");
  line.addParams(params_, "gravity");
  line.addCheck([this] {
    if (params_.up == 0) throw UsageError("gravity.up is an axis: 1, 2, 3 or negative");
  });
}

void GravityOption::read(const DepthSequence& sequence, const Console& console) {
  if (file_ == kIgnored) return;
  if (file_.empty()) {
    std::string remark;
    record_ = sequence.gravity(params_.std_deg * kDegree, &remark);
    console.note(remark);
  } else {
    readFile(sequence);
  }
  if (record_.empty()) return;
  std::size_t without = 0;
  for (const FrameFile& frame : sequence.frames()) without += !at(frame.stamp);
  if (without == sequence.frames().size())
    throw IoError(file_, "has no gravity at the time of any image: are the times those of one clock?");
  if (without > 0) console.note(counted(without, "image") + " without gravity at their times");
}

void GravityOption::readFile(const DepthSequence& sequence) {
  if (!sequence.stamped())
    throw IoError(file_, "the image names are no time stamps: gravity cannot be matched with them");
  if (holdsGravity(file_)) {
    record_ = readGravity(file_, params_.std_deg * kDegree);
  } else {
    const Trajectory poses = sequence.readPoses(file_);
    if (poses.empty()) throw IoError(file_, "has no poses at the times of the images");
    const Eigen::Vector3d up = (params_.up < 0 ? -1 : 1) * Eigen::Vector3d::Unit(std::abs(params_.up) - 1);
    record_ = gravityOf(poses, up, params_.std_deg * kDegree);
  }
}

std::string GravityOption::toIni() const {
  if (file_.empty() && record_.empty()) return {};
  const std::string file = file_.empty() ? "" : fmt::format("gravity = {}\n", file_);
  return file +
         fmt::format("gravity.std_deg = {}\ngravity.up = {}\n", text::shortest(params_.std_deg), params_.up);
}

}  // namespace facetloc
