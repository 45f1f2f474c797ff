// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "results/pose_columns.h"

#include <facetloc/io/atomic_file.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

constexpr double kStampRounding = 1e-6;        // [s] stamps are written with 6 decimals
constexpr double kQuaternionTolerance = 1e-2;  // tolerance of |q|^2: TUM's own files have four decimals
constexpr double kWidestGap = 5;               // between poses to interpolate, by the tolerance
constexpr std::size_t kColumns = 8;

StampedPose parsePose(const std::vector<std::string_view>& words) {
  if (words.size() != kColumns)
    throw std::invalid_argument(fmt::format("has {} columns instead of {}", words.size(), kColumns));
  std::array<double, kColumns> values{};
  for (std::size_t i = 0; i < kColumns; ++i) {
    const auto value = text::to<double>(words[i]);
    if (!value || !std::isfinite(*value))
      throw std::invalid_argument(text::quoted(words[i]) + " is not a finite number");
    values[i] = *value;
  }
  PoseColumns columns;
  std::copy(values.begin() + 1, values.end(), columns.begin());
  if (!plausible::isStamp(values[0])) throw std::invalid_argument("its stamp is impossible");
  return {values[0], fromColumns(columns, kQuaternionTolerance)};
}

}  // namespace

Trajectory::Trajectory(std::vector<StampedPose> poses) : poses_(std::move(poses)) {
  std::stable_sort(poses_.begin(), poses_.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
}

std::optional<Eigen::Isometry3d> Trajectory::at(double stamp, double tolerance) const {
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), stamp,
                                      [](const StampedPose& p, double s) { return p.stamp < s; });
  const bool is_between = after != poses_.begin() && after != poses_.end() &&
                          after->stamp - after[-1].stamp <= kWidestGap * tolerance + kStampRounding;
  return is_between ? interpolated(stamp) : nearest(stamp, tolerance);
}

std::optional<Eigen::Isometry3d> Trajectory::nearest(double stamp, double tolerance) const {
  const auto distance = [stamp](const StampedPose& p) { return std::abs(p.stamp - stamp); };
  auto best = std::lower_bound(poses_.begin(), poses_.end(), stamp,
                               [](const StampedPose& p, double s) { return p.stamp < s; });
  if (best == poses_.end() || (best != poses_.begin() && distance(best[-1]) <= distance(*best))) {
    if (best == poses_.begin()) return {};
    --best;
  }
  if (!(distance(*best) <= tolerance + kStampRounding)) return {};
  return best->T_w_c;
}

std::optional<Eigen::Isometry3d> Trajectory::interpolated(double stamp) const {
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), stamp,
                                      [](const StampedPose& p, double s) { return p.stamp < s; });
  if (after == poses_.end()) return {};
  if (after->stamp == stamp) return after->T_w_c;
  if (after == poses_.begin()) return {};
  const StampedPose &a = after[-1], &b = *after;
  const double share = (stamp - a.stamp) / (b.stamp - a.stamp);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(a.T_w_c.linear())
                   .slerp(share, Eigen::Quaterniond(b.T_w_c.linear()))
                   .normalized()
                   .toRotationMatrix();
  T.translation() = (1 - share) * a.T_w_c.translation() + share * b.T_w_c.translation();
  return T;
}

Trajectory readTumTrajectory(const std::filesystem::path& path) {
  std::vector<StampedPose> poses;
  files::forEachLine(files::readText(path), path.string(), [&poses](std::string_view line) {
    const auto words = text::words(text::withoutComment(line));
    if (!words.empty()) poses.push_back(parsePose(words));
  });
  return Trajectory(std::move(poses));
}

void writeTumTrajectory(const std::filesystem::path& path, const std::vector<StampedPose>& poses) {
  writeTextAtomically(path, [&](std::ostream& out) {
    out << tum::kHeader;
    for (const StampedPose& pose : poses) out << tum::line(pose);
  });
}

}  // namespace facetloc
