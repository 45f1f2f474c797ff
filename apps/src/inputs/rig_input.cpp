// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/rig_input.h"

#include "base/text.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <utility>

namespace facetloc {
namespace {

constexpr double kMoment = 0.1;                           // between images of one moment [s]
constexpr double kSpeed = 0.7, kTurnRate = 40 * kDegree;  // a walk [m/s, rad/s]

/** The image nearest in time; nothing if none is of the moment. */
std::optional<std::size_t> imageAt(const DepthSequence& sequence, double stamp) {
  const std::vector<FrameFile>& frames = sequence.frames();
  const auto after = std::lower_bound(frames.begin(), frames.end(), stamp,
                                      [](const FrameFile& frame, double t) { return frame.stamp < t; });
  std::optional<std::size_t> nearest;
  double least = kMoment;
  for (auto frame = after == frames.begin() ? after : after - 1; frame != frames.end() && frame <= after;
       ++frame)
    if (const double dt = std::abs(frame->stamp - stamp); dt <= least)
      least = dt, nearest = static_cast<std::size_t>(frame - frames.begin());
  return nearest;
}

}  // namespace

std::vector<SideRecording> openSides(const RigFile& rig, const Camera& first, const DepthInput& input,
                                     const CommandLine& line, const Console& console) {
  const auto requireMounting = [](const std::filesystem::path& folder, const Camera& camera) {
    if (!camera.mounting)
      throw IoError(folder.string(),
                    "its camera.ini has no mounting on the robot (mount_height, mount_tilt_deg, "
                    "...), which a rig needs");
  };
  requireMounting(rig.cameras.front(), first);
  std::vector<SideRecording> sides;
  for (std::size_t i = 1; i < rig.cameras.size(); ++i) {
    const std::filesystem::path& folder = rig.cameras[i];
    RecordingHints hints = input.recording;
    hints.camera.clear();  // which names the first one
    DepthSequence sequence = openSequence(folder.string(), hints, console);
    Camera camera = input.camera(sequence.camera(), line);
    requireMounting(folder, camera);
    const PoseWithCovariance T_first_c = rig.between(*first.mounting, *camera.mounting);
    sides.push_back({std::move(sequence), std::move(camera), T_first_c});
  }
  return sides;
}

std::vector<Eigen::Isometry3d> posesOf(const std::vector<SideRecording>& sides) {
  std::vector<Eigen::Isometry3d> poses;
  for (const SideRecording& side : sides) poses.push_back(side.T_first_c.T);
  return poses;
}

std::string rigLine(const RigFile& rig) {
  std::string line = "# rig:";
  for (const std::filesystem::path& camera : rig.cameras) line += " " + camera.filename().string();
  return fmt::format("{}, rotation_std_deg {}, translation_std {}\n", line,
                     text::shortest(rig.rotation_std / kDegree), text::shortest(rig.translation_std));
}

RigViews::RigViews(const DepthSequence& sequence, const Camera& camera,
                   const std::vector<SideRecording>& sides, const DepthInput& input, PosesByTime odometry,
                   const OdometryError& error)
    : sequence_(sequence),
      sides_(sides),
      width_(input.width),
      builder_(camera, input.view),
      odometry_(std::move(odometry)),
      error_(error) {
  for (const SideRecording& side : sides) side_builders_.emplace_back(side.camera, input.view);
}

View RigViews::at(std::size_t image, const std::optional<Gravity>& gravity) {
  const double stamp = sequence_.frames()[image].stamp;
  View first = viewOf(sequence_, image, width_, builder_, gravity);
  sides_milliseconds_ = 0;
  std::vector<PosedView> others;
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    const auto& [sequence, camera, T_first_c] = sides_[k];
    const auto beside = imageAt(sequence, stamp);
    if (!beside) continue;
    auto view = std::make_shared<const View>(viewOf(sequence, *beside, width_, side_builders_[k]));
    others.push_back({std::move(view), motion(stamp, sequence.frames()[*beside].stamp) * T_first_c});
    sides_milliseconds_ += side_builders_[k].segmentMilliseconds() + side_builders_[k].featuresMilliseconds();
  }
  if (others.empty()) return first;
  return joined(first, others);
}

// The motion of the first camera between two times.
PoseWithCovariance RigViews::motion(double from, double to) const {
  if (from == to) return {};
  const auto before = odometry_ ? odometry_(from) : std::nullopt,
             after = odometry_ ? odometry_(to) : std::nullopt;
  if (before && after)
    return motionByOdometry(before->inverse() * *after, builder_.camera().mounting, error_);
  Vector6d std;
  std << Eigen::Vector3d::Constant(kTurnRate * (to - from)), Eigen::Vector3d::Constant(kSpeed * (to - from));
  return {Eigen::Isometry3d::Identity(), std.cwiseAbs2().asDiagonal()};
}

}  // namespace facetloc
