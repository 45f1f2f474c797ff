// SPDX-License-Identifier: BSD-3-Clause
#include "base/pose_axes.h"
#include "base/text.h"
#include "bytes/files.h"
#include "recordings/pose_table.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <functional>
#include <optional>
#include <set>
#include <stdexcept>

namespace facetloc {

PoseReading PoseReading::of(std::string_view words) {
  PoseReading reading;
  for (const std::string_view part : text::split(words, ',')) {
    const std::string_view word = text::trimmed(part);
    if (word == "wxyz")
      reading.w_first = true;
    else if (word == "inverse")
      reading.inverse = true;
    else if (word == "base")
      reading.axes = Axes::base;
    else if (word == "opengl")
      reading.axes = Axes::opengl;
    else if (word != "auto" && !word.empty())
      throw std::invalid_argument(text::quoted(word) +
                                  " is no convention of poses (known: auto, wxyz, inverse, base, opengl)");
  }
  return reading;
}

Trajectory readTrajectory(const fs::path& path, std::string* remark) {
  internal::ReadPoses read = internal::stampedPoses(internal::readPoseTable(path), path);
  if (remark) *remark = std::move(read.remark);
  return std::move(read.poses);
}

}  // namespace facetloc

namespace facetloc::internal {
namespace {

Trajectory changed(const Trajectory& poses, const std::function<void(StampedPose&)>& change) {
  std::vector<StampedPose> all = poses.poses();
  for (StampedPose& pose : all) change(pose);
  return Trajectory(std::move(all));
}

std::string lostPoses(const PoseTable& table, const fs::path& path) {
  if (const std::size_t n = table.lost(); n > 0)
    return fmt::format("{}: {} of its {} poses {} lost (NaN or zeros) and left out", path.string(), n,
                       table.rows.size(), n == 1 ? "is" : "are");
  return {};
}

/** \param stampOf the i-th row */
template <typename StampOf>
Trajectory posesAt(const PoseTable& table, StampOf stampOf) {
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    if (const auto& T = table.rows[i].T_w_c) poses.push_back({stampOf(i), *T});
  return Trajectory(std::move(poses));
}

ReadPoses byOrder(const PoseTable& table, const ImageTimes& images, const fs::path& path) {
  return {posesAt(table, [&](std::size_t i) { return images.stamps[i]; }),
          fmt::format("{}: its {} poses are those of the images, in their order", path.string(),
                      table.rows.size())};
}

/** Stamps 0, 1, 2, ... or 1, 2, 3, ..., as they are of no clock. */
bool areRowNumbers(const PoseTable& table) {
  constexpr std::size_t kEnough = 3;
  const double first = table.rows.front().stamp;
  if (table.rows.size() < kEnough || (first != 0 && first != 1)) return false;
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    if (table.rows[i].stamp != first + static_cast<double>(i)) return false;
  return true;
}

/** Rows of which the number of an image is the index, as KITTI's. */
bool areIndexed(const PoseTable& table, const ImageTimes& images) {
  const double rows = static_cast<double>(table.rows.size());
  return images.unit.counted && !images.numbers.empty() &&
         std::all_of(images.numbers.begin(), images.numbers.end(), [rows](double n) { return n < rows; });
}

ReadPoses byIndex(const PoseTable& table, const ImageTimes& images, const fs::path& path) {
  PoseTable of_images = table;
  of_images.rows.clear();
  for (const double n : images.numbers) of_images.rows.push_back(table.rows[static_cast<std::size_t>(n)]);
  return {posesAt(of_images, [&](std::size_t i) { return images.stamps[i]; }),
          fmt::format("{}: image N is taken to have pose N, counted from 0", path.string())};
}

}  // namespace

std::optional<Eigen::Isometry3d> readPoseOfImage(const fs::path& path) {
  return poseOfNumbers(numbersOf(files::readText(path), path), path);
}

std::optional<Eigen::Isometry3d> poseOfNumbers(std::vector<double> numbers, const fs::path& path) {
  constexpr std::size_t kColumns = 7, kRows = 12, kMatrix = 16;
  const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
  if (numbers.size() == kRows) numbers.insert(numbers.end(), {0, 0, 0, 1});
  try {
    if (numbers.size() == kColumns && finite) {
      std::array<double, kColumns> columns{};
      std::copy(numbers.begin(), numbers.end(), columns.begin());
      return poseOfColumns(columns);
    }
    if (numbers.size() == kMatrix && finite)
      return poseOfMatrix(Eigen::Map<const Eigen::Matrix4d>(numbers.data()).transpose());
  } catch (const std::invalid_argument& e) {
    throw IoError(path.string(), e.what());
  }
  if (numbers.size() != kColumns && numbers.size() != kMatrix)
    throw IoError(path.string(), fmt::format("has {} numbers instead of the 16 of a pose", numbers.size()));
  return {};
}

ReadPoses RecordedPoses::read(const ImageTimes& images) const {
  if (!trajectory.empty()) {
    PoseTable table = readPoseTable(trajectory);
    if (!(seconds > 0)) return matched(table, images, trajectory);
    table.unit = {seconds};
    return stampedPoses(table, trajectory);
  }
  std::vector<StampedPose> poses = listed;
  for (const PoseFile& file : of_images)
    if (const auto T_w_c = readPoseOfImage(file.path)) poses.push_back({file.stamp, *T_w_c});
  return {Trajectory(std::move(poses)), {}};
}

bool haveSameNumbers(const PoseTable& table, const ImageTimes& images) {
  if (!table.stamped || images.numbers.empty()) return false;
  const std::vector<double> stamps = table.stamps();
  const std::set<double> known(stamps.begin(), stamps.end());
  const auto n = std::count_if(images.numbers.begin(), images.numbers.end(),
                               [&](double number) { return known.count(number) > 0; });
  const auto all = static_cast<std::ptrdiff_t>(images.numbers.size());
  const bool as_many = table.rows.size() == images.numbers.size();  // then an order that fits all counts more
  return as_many ? n == all : 2 * n > all;
}

ReadPoses stampedPoses(const PoseTable& table, const fs::path& path) {
  if (!table.stamped)
    throw IoError(path.string(), "has poses without time stamps, which belong to the images of a recording");
  ReadPoses read{posesAt(table, [&](std::size_t i) { return table.rows[i].stamp * table.unit.seconds; }), {}};
  if (table.unit.seconds != 1 && !table.unit.counted)
    addSentence(fmt::format("{}: its stamps are taken to be {}", path.string(), table.unit.toString()),
                read.remark);
  addSentence(lostPoses(table, path), read.remark);
  return read;
}

ReadPoses matched(const PoseTable& table, const ImageTimes& images, const fs::path& path) {
  if (table.rows.empty()) return {};
  if (haveSameNumbers(table, images)) {
    const double unit = images.unit.seconds;
    return {posesAt(table, [&](std::size_t i) { return table.rows[i].stamp * unit; }),
            lostPoses(table, path)};
  }
  if (table.stamped && !images.unit.counted && !areRowNumbers(table)) return stampedPoses(table, path);
  ReadPoses read;
  if (table.rows.size() == images.stamps.size())
    read = byOrder(table, images, path);
  else if (!table.stamped && areIndexed(table, images))
    read = byIndex(table, images, path);
  else
    throw IoError(
        path.string(),
        fmt::format("has {} poses{}, but there are {} images{}: they cannot be assigned to each other; add a "
                    "list of the images with their times (depth.txt: stamp and file name)",
                    table.rows.size(),
                    !table.stamped         ? " without time stamps"
                    : areRowNumbers(table) ? ", which are numbered and have no times"
                                           : "",
                    images.stamps.size(),
                    images.unit.counted ? ", whose names are numbers and no times" : ""));
  addSentence(lostPoses(table, path), read.remark);
  return read;
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

Trajectory readAs(const PoseReading& reading, const Trajectory& poses,
                  const std::optional<Eigen::Isometry3d>& T_b_c) {
  if (reading.isUsual()) return poses;
  using Axes = PoseReading::Axes;
  Eigen::Isometry3d T_other_optical = Eigen::Isometry3d::Identity();
  if (reading.axes == Axes::opengl) T_other_optical.linear() = opticalInOpenGl();
  if (reading.axes == Axes::base) T_other_optical = T_b_c ? *T_b_c : Eigen::Isometry3d(opticalInBase());
  return changed(poses, [&](StampedPose& pose) {
    pose.T_w_c = poseAsMeant(reading.w_first, reading.inverse, pose.T_w_c) * T_other_optical;
  });
}

}  // namespace facetloc::internal
