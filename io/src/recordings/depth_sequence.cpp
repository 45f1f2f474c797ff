// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"
#include "clouds/cloud_axes.h"
#include "images/depth_file.h"
#include "recordings/image_container.h"
#include "recordings/image_list.h"
#include "recordings/message_file.h"
#include "recordings/pose_table.h"
#include "recordings/recording_layout.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>
#include <facetloc/io/segment_file.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fmt/format.h>
#include <map>
#include <numeric>

namespace facetloc {
namespace internal {
namespace {

void requireUniqueNames(const std::vector<FrameFile>& frames, const fs::path& source) {
  std::map<std::string, fs::path> seen;
  for (const FrameFile& frame : frames) {
    const auto [other, is_new] = seen.emplace(frame.name, frame.path);
    if (!is_new)
      throw IoError(source.string(), fmt::format("two frames have the name '{}': {} and {}", frame.name,
                                                 other->second.string(), frame.path.string()));
  }
}

/** As of images: their names are their stamps, or their numbers if the stamps do not tell them apart. */
RecordingLayout layoutOf(const ImageContainer& container, const std::vector<fs::path>& beside) {
  std::vector<ListedImage> images;
  bool ascending = true;
  for (std::size_t i = 0; i < container.size(); ++i) {
    images.push_back({container.path(i), container.stamp(i), container.pose(i)});
    ascending = ascending && (i == 0 || images[i].stamp > images[i - 1].stamp);
  }
  if (ascending) return layoutOf(images, beside, {});
  RecordingLayout layout;
  for (std::size_t i = 0; i < images.size(); ++i)
    layout.frames.push_back({fmt::format("frame_{}", i), images[i].path, static_cast<double>(i)});
  return layout;
}

}  // namespace

/** Finds out the kind of a recording, whatever its layout. */
class SequenceReader {
public:
  /** Lists the images. Throws IoError if it is no recording. */
  SequenceReader(const fs::path& path, const RecordingHints& hints) : path_(path), hints_(hints) {
    files::requireNoPointer(path);
    if (!files::isThere(path)) throw IoError(path.string(), "does not exist");
    listImages();
    requireUniqueNames(layout_.frames, path);
  }

  /** Throws IoError if there are no images, and with advice if nothing says which camera took PNGs. */
  DepthSequence read() const {
    if (layout_.frames.empty())
      throw IoError(path_.string(), fmt::format("has no depth images ({}){}", imageEndings(),
                                                files::isFolder(path_) ? "; " + foundIn(path_) : ""));
    if (hints_.depth_scale > 0 && !needsCamera())
      throw IoError(path_.string(), "has no PNG images, so that a depth scale does not apply");
    const bool of_segments = hasSegments();
    if (of_segments && !hints_.segments)
      throw IoError(path_.string(), "holds segments, for facetloc_localize, facetloc_register and "
                                    "facetloc_render; this tool needs the depth images");
    DepthSequence sequence = readWith(camera());
    sequence.of_segments_ = of_segments;
    if (!sequence.camera() && needsCamera()) throw IoError(path_.string(), adviceOnCamera(layout_, asked_));
    if (!of_segments && !container_ && isCloud(layout_.frames.front().path)) try {
        const std::string words = sequence.loadAsStored(0).remark;
        if (!words.empty()) sequence.remarks_.push_back(words);
      } catch (const IoError&) {  // told when it is loaded
      }
    return sequence;
  }

  /** For who asks for its poses alone, which may be there without images. */
  DepthSequence readWithoutCamera() const {
    return readWith(cameraOf(layout_, beside_, within_, asked_));  // which may say where its y axis points
  }

private:
  void listImages() {
    const bool is_container = isContainer(path_);
    const bool is_folder = files::isFolder(path_) && !is_container;
    asked_ = files::isFolder(path_) ? fs::absolute(path_) : fs::absolute(path_).parent_path();
    const fs::path images = is_folder ? folderOfImages(path_) : path_;
    const bool has_depth = is_folder && images != path_;
    beside_ = placesBeside(has_depth ? images : asked_, asked_);
    const auto add = [this](const fs::path& folder) {
      if (std::find(within_.begin(), within_.end(), folder) == within_.end()) within_.push_back(folder);
    };
    if (has_depth) add(images), add(images.parent_path());
    add(asked_);
    if (text::lower(asked_.filename().string()).find("depth") != std::string::npos) add(asked_ / "..");
    if (is_folder)
      layout_ = layoutOf(imagesOfFolder(images), beside_, within_);
    else if (isImage(path_))
      layout_ = layoutOf({{path_}}, beside_, within_);
    else if (isImageList(path_))
      layout_ = layoutOf(imagesOfList(path_), beside_, {});
    else if (is_container)
      layout_ = layoutOf(*(container_ = openContainer(path_, hints_.topic)), beside_);
    else
      throw IoError(path_.string(),
                    fmt::format("is no recording: expected a folder, a depth image ({}), a recording "
                                "in one file ({}), or a list in a .txt, .lst or .csv file{}{}",
                                imageEndings(), containerEndings(), adviceOnFile(path_).empty() ? "" : "; ",
                                adviceOnFile(path_)));
  }

  bool needsCamera() const {
    return std::any_of(layout_.frames.begin(), layout_.frames.end(),
                       [](const FrameFile& frame) { return isDepthFile(frame.path); });
  }

  /** Throws IoError if there are images as well. */
  bool hasSegments() const {
    const auto isOfSegments = [](const FrameFile& frame) { return isSegmentFile(frame.path); };
    const auto n = std::count_if(layout_.frames.begin(), layout_.frames.end(), isOfSegments);
    if (n > 0 && n < static_cast<std::ptrdiff_t>(layout_.frames.size()))
      throw IoError(path_.string(), "has depth images and files of segments: list one kind alone");
    return n > 0;
  }

  DepthSequence readWith(std::optional<RecordedCamera> camera) const {
    DepthSequence sequence;
    sequence.frames_ = layout_.frames;
    sequence.stamped_ = layout_.stamped;
    sequence.timed_ = layout_.stamped && !layout_.assumed;
    sequence.container_ = container_;
    sequence.times_ = std::make_shared<const ImageTimes>(layout_.times());
    sequence.layout_ =
        container_ ? "a recording in " + std::string(fs::is_directory(path_) ? "several files" : "one file")
                   : layout_.toString();
    sequence.time_offset_ = hints_.time_offset;
    sequence.poses_are_ = PoseReading::of(hints_.poses_are);
    const auto remark = [&sequence](std::string words) {
      if (!words.empty()) sequence.remarks_.push_back(std::move(words));
    };
    if (container_) remark(container_->remark());
    remark(layout_.remark);
    if (camera) {
      sequence.camera_ = std::move(camera->file);
      remark(std::move(camera->remark));
      if (!sequence.camera_->isPinhole() && sequence.camera_->camera.intrinsics.valid())
        sequence.lens_ = std::make_shared<const LensCorrection>(
            sequence.camera_->camera.intrinsics, sequence.camera_->lens, sequence.camera_->depth_is);
    }
    try {
      ReadPoses poses = layout_.poses.read(*sequence.times_);
      remark(std::move(poses.remark));
      sequence.ground_truth_ = sequence.asOfImages(poses.poses, sequence.poses_are_);
    } catch (const IoError&) {  // irrelevant unless poses are requested
      sequence.ground_truth_fault_ = std::current_exception();
    }
    return sequence;
  }

  std::optional<RecordedCamera> camera() const {
    const bool is_file = files::isFile(hints_.camera);
    std::optional<RecordedCamera> camera;
    const bool of_map = is_file && isMapFile(hints_.camera);
    if (is_file && !of_map)
      camera = RecordedCamera{readCameraFile(hints_.camera)};
    else
      camera = cameraOf(layout_, beside_, within_, asked_);
    if (!camera && container_) camera = RecordedCamera{container_->camera()};
    if (of_map) {
      const std::string remark = camera || hints_.depth_scale > 0 || !needsCamera()
                                     ? ""
                                     : "the unit of its depth is unknown and assumed to be millimetres; "
                                       "otherwise set depth_scale in a camera.ini beside it";
      camera = RecordedCamera{cameraOfMap(hints_.camera, camera ? std::optional(camera->file) : std::nullopt),
                              remark};
    }
    if (!hints_.camera.empty() && !is_file) camera = withPreset(hints_.camera, camera, layout_);
    if (camera && hints_.depth_scale > 0) camera->file.depth_scale = hints_.depth_scale;
    return camera;
  }

  fs::path path_, asked_;
  RecordingHints hints_;
  std::vector<fs::path> beside_;  // where files that belong to it can be
  std::vector<fs::path> within_;  // those of these that are its own
  RecordingLayout layout_;
  std::shared_ptr<const ImageContainer> container_;
};

}  // namespace internal

namespace {

/** As it is stored. */
DepthImage depthOf(const fs::path& path, StoredDepth values, const CameraFile& file) {
  const Intrinsics& intrinsics = file.camera.intrinsics;
  internal::requireSizeOf(intrinsics, values.width, values.height, path);
  return {intrinsics,
          values.metres.empty() ? metresOf(values.numbers, file.depth_scale) : std::move(values.metres)};
}

DepthImage depthOf(const fs::path& path, const CameraFile& file) {
  return depthOf(path, readDepthValues(path), file);
}

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
  for (const std::string& words : remarks_) internal::addSentence(words, all);
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
  if (isStoredAsCloud(index)) return internal::imageOfPcd(path, knownIntrinsics());
  if (!container_) return {depthOf(path, *camera_)};
  DepthImage image = container_->read(index);
  internal::requireSizeOf(camera_->camera.intrinsics, image.camera.width, image.camera.height, path);
  image.camera = camera_->camera.intrinsics;
  return {std::move(image)};
}

bool DepthSequence::isStoredAsCloud(std::size_t index) const {
  return !container_ && internal::isCloud(frames_.at(index).path);
}

std::optional<std::vector<std::uint32_t>> DepthSequence::pixelsOfPoints(std::size_t index) const {
  if (!isStoredAsCloud(index)) return {};
  internal::CloudImage found = loadAsStored(index);
  if (found.pixels.empty()) {
    found.pixels.resize(found.image.depth.size());
    std::iota(found.pixels.begin(), found.pixels.end(), 0);
  }
  return std::move(found.pixels);
}

DepthImage DepthSequence::load(std::size_t index, int working_width) const {
  return worked(loadAsStored(index).image, index, working_width);
}

/** The image of a file whose values have been read already. */
DepthImage DepthSequence::imageOf(std::size_t index, StoredDepth values) const {
  return worked(depthOf(frames_.at(index).path, std::move(values), *camera_), index, 0);
}

DepthImage DepthSequence::worked(DepthImage image, std::size_t index, int working_width) const {
  if (lens_ && !isStoredAsCloud(index)) image = (*lens_)(image);
  fillHoleGrid(image);
  return workingImage(image, working_width);
}

std::vector<Segment> DepthSequence::segments(std::size_t index) const {
  return readSegments(frames_.at(index).path);
}

DepthImage readDepthPng(const fs::path& path, const CameraFile& file) { return depthOf(path, file); }

void writeDepthPng(const fs::path& path, const DepthImage& image, double depth_scale) {
  Raster<std::uint16_t> raster{image.camera.width, image.camera.height, 1, {}};
  raster.data.resize(image.depth.size());
  std::transform(image.depth.begin(), image.depth.end(), raster.data.begin(), [&](float z) {
    const double value = std::round(z * depth_scale);
    return static_cast<std::uint16_t>(value > 0 && value < kNotMeasured ? value : 0);
  });
  writePng(path, raster);
}

DepthImage readDepthPcd(const fs::path& path, const std::optional<Intrinsics>& camera) {
  return internal::imageOfPcd(path, camera).image;
}

}  // namespace facetloc
