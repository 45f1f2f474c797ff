// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "clouds/cloud_axes.h"
#include "clouds/point_formats.h"
#include "images/depth_file.h"
#include "recordings/image_container.h"
#include "recordings/image_list.h"
#include "recordings/message_file.h"
#include "recordings/recorded_poses.h"
#include "recordings/sequence_reader.h"

#include <facetloc/features/hole_grid.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/png.h>
#include <facetloc/io/segment_file.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr std::uint16_t kNotMeasured = 65535;  // value of a PNG, beside 0: 7-Scenes and some drivers have it

/** An image of another size was not taken with this camera. */
void requireSize(const fs::path& path, int width, int height, const Intrinsics& camera) {
  if (width == camera.width && height == camera.height) return;
  throw IoError(path.string(), fmt::format("is of {}x{} pixels, but the camera of {}x{}: the calibration in "
                                           "camera.ini must be for images of this size",
                                           width, height, camera.width, camera.height));
}

DepthImage depthOf(const fs::path& path, const CameraFile& file);

}  // namespace

DepthSequence DepthSequence::open(const fs::path& path, const RecordingHints& hints) {
  return internal::SequenceReader(path, hints).read();
}

Trajectory DepthSequence::readTruth(const fs::path& path, double time_offset) {
  RecordingHints hints;
  hints.time_offset = time_offset;
  if (fs::is_directory(path) || internal::isImage(path) || internal::isContainer(path))
    return internal::SequenceReader(path, hints).readWithoutCamera().groundTruth();
  return internal::delayed(readTrajectory(path), -time_offset);
}

/** Poses are looked up at the times of the images. */
Trajectory DepthSequence::asOfImages(const Trajectory& poses, const PoseReading& reading) const {
  std::optional<Eigen::Isometry3d> T_b_c;
  if (camera_ && camera_->camera.mounting) T_b_c = camera_->camera.mounting->T_b_c();
  const Trajectory at_images = internal::delayed(internal::readAs(reading, poses, T_b_c), -time_offset_);
  return camera_ && camera_->y_axis_up ? internal::mirrored(at_images) : at_images;
}

const Trajectory& DepthSequence::groundTruth() const {
  if (ground_truth_fault_) std::rethrow_exception(ground_truth_fault_);
  return ground_truth_;
}

/** Poses of the robot are those that the mounting, or a user's statement about them, turns into the
 * camera's. */
std::string DepthSequence::frameOfPoses(const PoseReading& reading) const {
  const bool has_mounting = camera_ && camera_->camera.mounting;
  return container_ && reading.isUsual() && !has_mounting ? container_->frame() : std::string();
}

Trajectory DepthSequence::readAs(const fs::path& path, const PoseReading& reading,
                                 std::string* remark) const {
  if (remark) remark->clear();
  const bool is_container = internal::isContainer(path);
  internal::ReadPoses read = is_container ? internal::readContainerPoses(path, frameOfPoses(reading))
                                          : internal::matched(internal::readPoseTable(path), *times_, path);
  if (remark) *remark = std::move(read.remark);
  return asOfImages(read.poses, reading);
}

Trajectory DepthSequence::readPoses(const fs::path& path, std::string* remark) const {
  return readAs(path, poses_are_, remark);
}

Trajectory DepthSequence::readOdometry(const fs::path& path, std::string* remark) const {
  return readAs(path, {}, remark);
}

bool DepthSequence::isOfMessages(const fs::path& path) { return internal::isMessageRecording(path); }

GravityRecord DepthSequence::gravity(double std, std::string* remark) const {
  internal::ReadGravity read;
  if (container_ && stamped_) read = container_->gravity(std);
  if (remark) *remark = std::move(read.remark);
  return std::move(read.gravity);
}

std::string DepthSequence::remark() const {
  std::string all;
  for (const std::string& words : remarks_) all += (all.empty() ? "" : "; ") + words;
  return all;
}

/** Nothing while each image says its own. */
std::optional<Intrinsics> DepthSequence::knownIntrinsics() const {
  if (!camera_ || !camera_->camera.intrinsics.valid()) return {};
  return camera_->camera.intrinsics;
}

internal::CloudImage DepthSequence::loadAsStored(std::size_t index) const {
  const fs::path& path = frames_.at(index).path;
  if (of_segments_)
    throw IoError(path.string(),
                  "holds segments, and no depth image: localize, register and render it instead");
  if (!container_ && internal::isCloud(path)) return internal::imageOfPcd(path, knownIntrinsics());
  if (!container_) return {depthOf(path, *camera_)};
  DepthImage image = container_->read(index);
  requireSize(path, image.camera.width, image.camera.height, camera_->camera.intrinsics);
  image.camera = camera_->camera.intrinsics;
  return {std::move(image)};
}

DepthImage DepthSequence::load(std::size_t index, int working_width) const {
  DepthImage image = loadAsStored(index).image;
  if (lens_ && !(internal::isCloud(frames_[index].path) && !container_)) image = (*lens_)(image);
  fillHoleGrid(image);
  return workingImage(image, working_width);
}

std::vector<Segment> DepthSequence::segments(std::size_t index) const {
  return readSegments(frames_.at(index).path);
}

namespace {

/** As it is stored. */
DepthImage depthOf(const fs::path& path, const CameraFile& file) {
  const StoredDepth values = readDepthValues(path);
  const Intrinsics& intrinsics = file.camera.intrinsics;
  requireSize(path, values.width, values.height, intrinsics);
  if (!values.metres.empty()) return {intrinsics, values.metres};
  DepthImage image{intrinsics, std::vector<float>(values.numbers.size())};
  std::transform(values.numbers.begin(), values.numbers.end(), image.depth.begin(), [&](std::uint16_t value) {
    return value == kNotMeasured ? 0 : static_cast<float>(value / file.depth_scale);
  });
  return image;
}

}  // namespace

DepthImage readDepthPng(const std::filesystem::path& path, const CameraFile& file) {
  return depthOf(path, file);
}

void writeDepthPng(const std::filesystem::path& path, const DepthImage& image, double depth_scale) {
  Raster<std::uint16_t> raster{image.camera.width, image.camera.height, 1, {}};
  raster.data.resize(image.depth.size());
  std::transform(image.depth.begin(), image.depth.end(), raster.data.begin(), [&](float z) {
    const double value = std::round(z * depth_scale);
    return static_cast<std::uint16_t>(value > 0 && value < kNotMeasured ? value : 0);
  });
  writePng(path, raster);
}

namespace {

internal::FileCloud readOrganizedPoints(const fs::path& path) {
  const PcdHeader header(path);
  if (header.height() < 2 || header.width() < 2)
    throw IoError(path.string(),
                  fmt::format("is not an organized cloud ({}x{})", header.width(), header.height()));
  internal::FileCloud cloud;
  const pcl::PCLPointCloud2 raw = readPcd(path, header, &cloud.viewpoint);
  const auto coordinate = [&](const char* name) {
    const pcl::PCLPointField* field = fieldOf(raw, name);
    if (!field) throw IoError(path.string(), std::string("has no field ") + name);
    if (!isFloatingPoint(*field))
      throw IoError(path.string(), fmt::format("has a field {} that is not of floating point", name));
    return [&raw, type = field->datatype, offset = field->offset](std::size_t point) {
      return static_cast<float>(numberAt(type, raw.data.data() + point * raw.point_step + offset));
    };
  };
  const auto x = coordinate("x"), y = coordinate("y"), z = coordinate("z");
  cloud.points = pcl::PointCloud<pcl::PointXYZ>(header.width(), header.height());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) cloud.points[i] = pcl::PointXYZ(x(i), y(i), z(i));
  cloud.points.is_dense = false;
  return cloud;
}

}  // namespace

internal::CloudImage internal::imageOfPcd(const fs::path& path, const std::optional<Intrinsics>& camera) {
  const FileCloud cloud = readOrganizedPoints(path);
  if (camera)
    requireSize(path, static_cast<int>(cloud.points.width), static_cast<int>(cloud.points.height), *camera);
  if (auto found = imageOf(cloud, camera)) return std::move(*found);
  if (camera) throw IoError(path.string(), "its points are not where the camera of the camera.ini sees them");
  throw IoError(path.string(),
                "does not reveal its intrinsics: it has too few points, or they are not those of a pinhole "
                "camera at the origin (x right, y down, z forward); give a camera.ini");
}

DepthImage readDepthPcd(const std::filesystem::path& path, const std::optional<Intrinsics>& camera) {
  return internal::imageOfPcd(path, camera).image;
}

}  // namespace facetloc
