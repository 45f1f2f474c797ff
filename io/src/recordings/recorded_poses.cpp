// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/recorded_poses.h"

#include "files.h"
#include "plausible.h"
#include "shared/text.h"

#include <facetloc/io/error.h>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <fmt/format.h>
#include <functional>
#include <optional>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

constexpr double kTolerance = 1e-2;  // of a rotation matrix: files have as few as four decimals

Trajectory changed(const Trajectory& poses, const std::function<void(StampedPose&)>& change) {
  std::vector<StampedPose> all = poses.poses();
  for (StampedPose& pose : all) change(pose);
  return Trajectory(std::move(all));
}

/** Nothing if the pose was lost. */
std::optional<Eigen::Isometry3d> readPoseMatrix(const fs::path& path) {
  const std::string content = files::readText(path);
  const auto words = text::words(content);
  Eigen::Matrix4d m;
  if (words.size() != static_cast<std::size_t>(m.size()))
    throw IoError(path.string(), fmt::format("has {} numbers instead of the 16 of a pose", words.size()));
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto value = text::to<double>(words[i]);
    if (!value) throw IoError(path.string(), text::quoted(words[i]) + " is not a number");
    m(static_cast<Eigen::Index>(i) / 4, static_cast<Eigen::Index>(i) % 4) = *value;
  }
  if (!m.allFinite()) return {};
  const Eigen::Matrix3d R = m.topLeftCorner<3, 3>();
  const bool is_rotation =
      (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kTolerance &&
      R.determinant() > 0;
  if (!is_rotation || m.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw IoError(path.string(), "its matrix is not a pose");
  if (!plausible::isPosition(m.topRightCorner<3, 1>()))
    throw IoError(path.string(), "its pose is more than 1000 km away");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = svd.matrixU() * svd.matrixV().transpose();  // the nearest rotation
  T.translation() = m.topRightCorner<3, 1>();
  return T;
}

}  // namespace

Trajectory RecordedPoses::read() const {
  if (!trajectory.empty())
    return changed(readTumTrajectory(trajectory), [this](StampedPose& pose) { pose.stamp *= seconds; });
  std::vector<StampedPose> poses;
  for (const PoseFile& file : of_images)
    if (const auto T_w_c = readPoseMatrix(file.path)) poses.push_back({file.stamp, *T_w_c});
  return Trajectory(std::move(poses));
}

Trajectory mirrored(const Trajectory& poses) {
  return changed(poses, [](StampedPose& pose) {
    const Eigen::DiagonalMatrix<double, 3> M(1, -1, 1);
    pose.T_w_c.linear() = M * pose.T_w_c.linear() * M;
    pose.T_w_c.translation() = M * pose.T_w_c.translation();
  });
}

Trajectory delayed(const Trajectory& poses, double seconds) {
  return changed(poses, [seconds](StampedPose& pose) { pose.stamp += seconds; });
}

}  // namespace facetloc::internal
