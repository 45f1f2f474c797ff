// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/frame_truth.h"

#include "base/text.h"

#include <facetloc/features/segment_estimation.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/png.h>
#include <facetloc/registration/observability.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace facetloc {

namespace {

namespace fs = std::filesystem;

constexpr double kUnitTolerance = 1e-6;  // largest deviation of |n| from 1
constexpr const char* kPlanes = "planes.csv";
constexpr const char* kPlanesHeader = "plane,nx,ny,nz,d";
constexpr const char* kUnmapped = "unmapped.txt";
constexpr const char* kPoses = "groundtruth.txt";

std::vector<double> numbersOf(std::string_view line) {
  std::vector<double> numbers;
  for (const std::string_view cell : text::split(line, ',')) {
    const auto number = text::to<double>(cell);
    if (!number || !std::isfinite(*number)) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

/** Every step-th label of every step-th row, as of depth images. */
LabelImage subsampledLabels(const Raster<std::uint16_t>& image, int step) {
  LabelImage labels{(image.width + step - 1) / step, (image.height + step - 1) / step, {}};
  for (int v = 0; v < image.height; v += step)
    for (int u = 0; u < image.width; u += step)
      labels.label.push_back(image.data[static_cast<std::size_t>(v) * image.width + u]);
  return labels;
}

std::set<std::string> namesOf(const fs::path& path) {
  std::set<std::string> names;
  const std::string content = readText(path);
  for (const std::string_view line : text::lines(content))
    if (const auto name = text::trimmed(text::withoutComment(line)); !name.empty()) names.emplace(name);
  return names;
}

}  // namespace

TrueSegments trueSegments(const DepthImage& exact_depth, const LabelImage& labels, double min_pixels) {
  SegmentEstimationParams params;
  params.min_support = min_pixels;
  std::vector<int> ids;
  const std::vector<Segment> segments = estimateSegments(exact_depth, labels, {}, params, &ids);
  TrueSegments by_id;
  for (std::size_t i = 0; i < ids.size(); ++i) by_id.emplace(ids[i], segments[i]);
  return by_id;
}

bool sharedPlanesSuffice(const TrueSegments& query, const TrueSegments& model, double position_std,
                         double rotation_std) {
  std::vector<Segment> shared;
  for (const auto& [id, segment] : query)
    if (model.count(id)) shared.push_back(segment);
  return observability(informationOf(shared)).within(rotation_std, position_std);
}

std::map<int, WorldPlane> readPlanes(const fs::path& path) {
  const std::string content = readText(path);
  std::vector<std::string_view> lines = text::lines(content);
  for (std::string_view& line : lines) line = line.substr(0, line.find_last_not_of(text::kBlank) + 1);
  if (lines.front() != kPlanesHeader)
    throw IoError(path.string(), std::string("does not begin with ") + kPlanesHeader);
  std::map<int, WorldPlane> planes;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    const auto fail = [&](const std::string& cause) {
      throw IoError(path.string(), fmt::format("line {}: {}", i + 1, cause));
    };
    const std::vector<double> n = numbersOf(lines[i]);
    if (n.size() != 5) fail("is not a plane, " + std::string(kPlanesHeader));
    const WorldPlane plane{{n[1], n[2], n[3]}, n[4]};
    if (n[0] < 1 || n[0] > 65535 || n[0] != std::floor(n[0])) fail("the id must lie in [1, 65535]");
    if (std::abs(plane.normal.norm() - 1) > kUnitTolerance) fail("the normal is no unit vector");
    if (!planes.emplace(static_cast<int>(n[0]), plane).second) fail("this id occurs twice");
  }
  return planes;
}

void writePlanes(const fs::path& path, const std::map<int, WorldPlane>& planes) {
  writeTextAtomically(path, [&](std::ostream& out) {
    out << kPlanesHeader << "\n";
    for (const auto& [id, plane] : planes) {
      const auto& [n, d] = plane;
      out << id;
      for (const double value : {n.x(), n.y(), n.z(), d}) out << "," << text::shortest(value);
      out << "\n";
    }
  });
}

DepthImage exactDepth(const LabelImage& labels, const Intrinsics& camera,
                      const std::map<int, WorldPlane>& planes, const Eigen::Isometry3d& T_w_c) {
  DepthImage image{camera, std::vector<float>(labels.label.size(), 0.f)};
  for (int v = 0; v < labels.height; ++v)
    for (int u = 0; u < labels.width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * labels.width + u;
      if (labels.label[i] == 0) continue;
      const auto plane = planes.find(labels.label[i]);
      if (plane == planes.end())
        throw std::invalid_argument(fmt::format("no plane has the id {}", labels.label[i]));
      const auto& [n, d] = plane->second;
      const double z = (d - n.dot(T_w_c.translation())) / n.dot(T_w_c.linear() * camera.ray(u, v));
      if (isMeasured(static_cast<float>(z))) image.depth[i] = static_cast<float>(z);
    }
  return image;
}

std::optional<RenderedTruth> RenderedTruth::open(const fs::path& folder) {
  if (!fs::is_directory(folder / "labels") || !fs::exists(folder / kPlanes)) return {};
  RenderedTruth truth;
  truth.labels_ = folder / "labels";
  truth.camera_ = readCameraFile(folder / "camera.ini").camera.intrinsics;
  truth.planes_ = readPlanes(folder / kPlanes);
  return truth;
}

bool RenderedTruth::has(const std::string& name) const { return fs::exists(labels_ / (name + ".png")); }

TrueSegments RenderedTruth::segments(const std::string& name, const Eigen::Isometry3d& T_w_c,
                                     double min_pixels) const {
  const fs::path path = labels_ / (name + ".png");
  const Raster<std::uint16_t> image = readGreyPng(path, 16);
  if (image.width != camera_.width || image.height != camera_.height)
    throw IoError(path.string(), "its size is not the one in camera.ini");
  const int step = subsamplingStep(camera_, kWorkingWidth);
  const LabelImage labels = subsampledLabels(image, step);
  try {
    return trueSegments(exactDepth(labels, camera_.subsampled(step), planes_, T_w_c), labels, min_pixels);
  } catch (const std::invalid_argument& e) {
    throw IoError(path.string(), e.what());
  }
}

namespace {

/** Such as a bag, in the place of a trajectory. */
bool hasImages(const fs::path& file) {
  try {
    return !DepthSequence::open(file).frames().empty();
  } catch (const IoError&) {
    return false;
  }
}

PlaceTruth::Sequence openSequence(const fs::path& folder, double time_offset) {
  const Trajectory poses = DepthSequence::readTruth(folder, time_offset);
  if (poses.empty())
    throw IoError(folder.string(), "has no poses, in a groundtruth.txt or beside its images, or its images "
                                   "have no time stamps; nor have folders map, query and drive in it");
  PlaceTruth::Sequence sequence{folder, poses, RenderedTruth::open(folder), {}};
  if (fs::exists(folder / kUnmapped)) sequence.unmapped = namesOf(folder / kUnmapped);
  return sequence;
}

bool overlap(const Trajectory& a, const Trajectory& b) {
  if (a.empty() || b.empty()) return false;
  return a.poses().front().stamp <= b.poses().back().stamp &&
         b.poses().front().stamp <= a.poses().back().stamp;
}

}  // namespace

PlaceTruth PlaceTruth::open(const fs::path& path, double time_offset) {
  PlaceTruth truth;
  if (!fs::is_directory(path)) {
    const Trajectory poses = DepthSequence::readTruth(path, time_offset);
    if (!hasImages(path)) return PlaceTruth(poses);
    truth.add({path, poses, {}, {}});
    return truth;
  }
  for (const char* run : {"map", "query", "drive"})
    if (!fs::exists(path / kPoses) && fs::exists(path / run / kPoses))
      truth.add(openSequence(path / run, time_offset));
  if (truth.sequences_.empty()) truth.add(openSequence(path, time_offset));
  return truth;
}

void PlaceTruth::add(const Sequence& sequence) {
  std::vector<StampedPose> poses = poses_.poses();
  poses.insert(poses.end(), sequence.poses.poses().begin(), sequence.poses.poses().end());
  poses_ = Trajectory(std::move(poses));
  sequences_.push_back(sequence);
}

PlaceTruth PlaceTruth::of(const std::string& run) const {
  PlaceTruth truth;
  for (const Sequence& sequence : sequences_)
    if (sequence.folder.filename() == run) truth.add(sequence);
  if (!truth.sequences_.empty()) return truth;
  for (std::size_t i = 0; i < sequences_.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (overlap(sequences_[i].poses, sequences_[k].poses))
        throw IoError(
            sequences_[i].folder.string(),
            fmt::format(
                "its stamps overlap with {}, and images are known by their stamps alone: name the folders of "
                "the results after the runs, or give the folder of one run as the truth",
                sequences_[k].folder.string()));
  return *this;
}

bool PlaceTruth::unmapped(const std::string& name) const {
  return std::any_of(sequences_.begin(), sequences_.end(),
                     [&](const Sequence& sequence) { return sequence.unmapped.count(name) > 0; });
}

std::optional<TrueSegments> PlaceTruth::segments(const std::string& name, const Eigen::Isometry3d& T_w_c,
                                                 double min_pixels) const {
  for (const Sequence& run : sequences_)
    if (run.rendered && run.rendered->has(name)) return run.rendered->segments(name, T_w_c, min_pixels);
  return {};
}

}  // namespace facetloc
