// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"
#include "cli/app.h"
#include "cli/text.h"

#include <facetloc/features/params.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/gravity_record.h>

#include <cstdlib>
#include <fmt/core.h>
#include <optional>
#include <string>

namespace facetloc {

/** \brief How well a given direction of gravity is known. */
struct GravityParams {
  static constexpr const char* kTitle = "Error of a given gravity";
  double std_deg = 1;
  int up = 3;  ///< axis of the world of poses: 1 = x, 2 = y, 3 = z; negative: the other direction

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("std_deg", p.std_deg, 0.001, 90.0,
          "Error of a given direction of gravity about each horizontal axis, standard deviation [deg].",
          kForUsers);
    visit("up", p.up, -3, 3,
          "Upward axis of the world, for poses in place of gravity: 1 = x, 2 = y, 3 = z, negative = down.",
          kForUsers);
  }
};

/** \brief The options --gravity ... of tools that read images whose camera knows which way is down. */
class GravityOption {
public:
  void addOptions(CommandLine& line) {
    line.addOption("gravity", file_, "FILE",
                   "Downward direction of each image (RECORDINGS.md); none = ignore the IMU.");
    line.addParams(params_, "gravity");
    line.addCheck([this] {
      if (params_.up == 0) throw UsageError("gravity.up is an axis: 1, 2, 3 or negative");
    });
  }

  /** \brief Reads the file, or else the IMU in the recording, with remarks on where gravity is from and on
   * images that have none. Throws IoError. */
  void read(const DepthSequence& sequence, const Console& console) {
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

  /** \brief At the time of an image [s]; nothing without a source, or where it has a gap. */
  std::optional<Gravity> at(double stamp) const { return record_.at(stamp); }
  /** \brief As they are recorded beside maps and results; empty without gravity. */
  std::string toIni() const {
    if (file_.empty() && record_.empty()) return {};
    const std::string file = file_.empty() ? "" : fmt::format("gravity = {}\n", file_);
    return file + fmt::format("gravity.std_deg = {}\ngravity.up = {}\n", text::shortest(params_.std_deg),
                              params_.up);
  }

private:
  static constexpr const char* kIgnored = "none";  // file name that ignores gravity in the recording

  void readFile(const DepthSequence& sequence) {
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

  std::string file_;
  GravityParams params_;
  GravityRecord record_;
};

}  // namespace facetloc
