// SPDX-License-Identifier: BSD-3-Clause
#include "tools/image_trajectory.h"

#include "base/batch.h"
#include "base/text.h"

#include <facetloc/io/error.h>
#include <facetloc/io/text.h>
#include <facetloc/mapping/pose_check.h>

#include <algorithm>

namespace facetloc {
namespace {

constexpr std::size_t kImagesPerThread = 16;  // views built ahead of the one that is followed

/** How the images say that the camera has moved from keyframe to keyframe. */
std::vector<SeenMotion> seenMotions(const CameraTrajectory& trajectory) {
  std::vector<SeenMotion> motions;
  const auto stampOf = [&](int k) { return trajectory.images[trajectory.keyframes[k].image].stamp; };
  for (const KeyframeMotion& m : trajectory.motions)
    if (m.source == KeyframeMotion::Source::overlap && m.to == m.from + 1)
      motions.push_back({stampOf(m.from), stampOf(m.to), m.T_from_to.T});
  return motions;
}

}  // namespace

std::string inWords(const CameraTrajectory& trajectory) {
  return "way " + text::decimals(trajectory.length(), 1) + " m, " +
         counted(trajectory.keyframes.size(), "keyframe") + ", " +
         counted(static_cast<std::size_t>(trajectory.loops()), "comparison") + " with places seen before, " +
         counted(trajectory.parts().size(), "piece");
}

void ImageTrajectory::addOptions(CommandLine& line) {
  line.addOption("odometry", odometry_, "FILE",
                 "Poses that drift, as of wheels: of the camera, or of its robot if it is mounted.");
  line.addParams(params_, "mapping");
}

std::string ImageTrajectory::toIni() const {
  return (odometry_.empty() ? "" : "odometry = " + odometry_ + "\n") + facetloc::toIni(params_, "mapping");
}

Trajectory ImageTrajectory::odometry(const DepthSequence& sequence, const Camera& camera) const {
  if (odometry_.empty()) return {};
  if (!sequence.stamped())
    throw IoError(odometry_, "the image names are no time stamps: an odometry cannot be matched with them");
  Trajectory poses = sequence.readPoses(odometry_);
  if (poses.empty()) throw IoError(odometry_, "has no poses");
  if (!camera.mounting) return poses;
  std::vector<StampedPose> of_camera = poses.poses();
  for (StampedPose& pose : of_camera) pose.T_w_c = pose.T_w_c * camera.mounting->T_b_c();
  return Trajectory(std::move(of_camera));
}

int FoundTrajectory::report(const Console& console) const {
  for (const std::string& failure : failures) console.error(failure);
  return failures.empty() ? kOk : kFailed;
}

FoundTrajectory ImageTrajectory::find(const DepthSequence& sequence, const DepthInput& input,
                                      const Camera& camera, int threads, const Console& console) const {
  const Trajectory by_odometry = odometry(sequence, camera);
  TrajectoryEstimation estimation(params_);
  estimation.setNumberOfThreads(threads);
  const std::size_t n = sequence.frames().size();
  Batch batch(threads, n, console);
  std::vector<ViewBuilder> builders(batch.workers(), ViewBuilder(camera, input.view));
  const std::size_t chunk = kImagesPerThread * static_cast<std::size_t>(batch.workers());
  std::optional<Eigen::Isometry3d> before;
  std::size_t without_odometry = 0;
  for (std::size_t first = 0; first < n; first += chunk) {
    const std::size_t last = std::min(first + chunk, n);
    std::vector<View> views(last - first);
    batch.run(
        first, last, [&](std::size_t i) { return sequence.frames()[i].path.string(); },
        [&](std::size_t i, int worker) {
          views[i - first] = builders[worker].build(sequence.load(i, input.width));
        });
    for (std::size_t i = first; i < last; ++i) {
      const double stamp = sequence.frames()[i].stamp;
      const auto now = by_odometry.interpolated(stamp);
      std::optional<Eigen::Isometry3d> motion;
      if (now && before) motion = before->inverse() * *now;
      before = now;
      without_odometry += !now;
      estimation.add(std::move(views[i - first]), stamp, motion);
    }
  }
  FoundTrajectory found;
  found.failures = batch.failures();
  if (found.failures.size() == n) {
    found.report(console);
    throw IoError(sequence.frames().front().path.parent_path(), "none of its images can be read");
  }
  if (!by_odometry.empty() && without_odometry > 0)
    console.note(counted(without_odometry, "image") + " outside the time of the odometry");
  estimation.improve();
  found.trajectory = estimation.trajectory();
  if (!by_odometry.empty()) noteOdometry(found.trajectory, by_odometry, console);
  return found;
}

void ImageTrajectory::noteOdometry(const CameraTrajectory& found, const Trajectory& odometry,
                                   const Console& console) const {
  const PoseCheck check =
      checkPoses(seenMotions(found), [&](double stamp) { return odometry.interpolated(stamp); });
  if (!check.isKnown()) return;
  console.note("odometry and images disagree by " + check.as_given.inWords() +
               (check.cause.empty() ? "" : "; " + check.cause));
  if (check.wrong_convention) throw IoError(odometry_, "is not of these images as it stands; " + check.cause);
}

}  // namespace facetloc
