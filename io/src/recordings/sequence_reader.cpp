// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/sequence_reader.h"

#include "clouds/cloud_axes.h"
#include "images/depth_file.h"

#include <facetloc/io/error.h>
#include <facetloc/io/map_camera.h>
#include <facetloc/io/segment_file.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <fmt/format.h>
#include <map>
#include <system_error>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

std::string lower(std::string s) {
  for (char& c : s) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return s;
}

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

SequenceReader::SequenceReader(const fs::path& path, const RecordingHints& hints)
    : path_(path), hints_(hints) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw IoError(path.string(), "does not exist");
  listImages();
  requireUniqueNames(layout_.frames, path);
}

void SequenceReader::listImages() {
  std::error_code ignored;
  const bool is_container = isContainer(path_);
  const bool is_folder = fs::is_directory(path_, ignored) && !is_container;
  asked_ = fs::is_directory(path_, ignored) ? fs::absolute(path_) : fs::absolute(path_).parent_path();
  const fs::path images = is_folder ? folderOfImages(path_) : path_;
  const bool has_depth = is_folder && images != path_;
  beside_ = placesBeside(has_depth ? images : asked_, asked_);
  const auto add = [this](const fs::path& folder) {
    if (std::find(within_.begin(), within_.end(), folder) == within_.end()) within_.push_back(folder);
  };
  if (has_depth) add(images), add(images.parent_path());
  add(asked_);
  if (lower(asked_.filename().string()).find("depth") != std::string::npos) add(asked_ / "..");
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
                  fmt::format("is no sequence: expected a folder, a depth image ({}), a recording "
                              "in one file ({}), or a list in a .txt, .lst or .csv file{}{}",
                              imageEndings(), containerEndings(), adviceOnFile(path_).empty() ? "" : "; ",
                              adviceOnFile(path_)));
}

bool SequenceReader::needsCamera() const {
  return std::any_of(layout_.frames.begin(), layout_.frames.end(),
                     [](const FrameFile& frame) { return isDepthFile(frame.path); });
}

/** Throws IoError if there are images as well. */
bool SequenceReader::hasSegments() const {
  const auto isOfSegments = [](const FrameFile& frame) { return isSegmentFile(frame.path); };
  const auto n = std::count_if(layout_.frames.begin(), layout_.frames.end(), isOfSegments);
  if (n > 0 && n < static_cast<std::ptrdiff_t>(layout_.frames.size()))
    throw IoError(path_.string(), "has depth images and files of segments: list one kind alone");
  return n > 0;
}

std::optional<RecordedCamera> SequenceReader::camera() const {
  std::error_code ignored;
  const bool is_file = fs::is_regular_file(hints_.camera, ignored);
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

DepthSequence SequenceReader::readWithoutCamera() const {
  return readWith(cameraOf(layout_, beside_, within_, asked_));  // which may say where its y axis points
}

DepthSequence SequenceReader::readWith(std::optional<RecordedCamera> camera) const {
  DepthSequence sequence;
  sequence.frames_ = layout_.frames;
  sequence.stamped_ = layout_.stamped;
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

DepthSequence SequenceReader::read() const {
  if (layout_.frames.empty()) {
    std::error_code ignored;
    const bool is_folder = fs::is_directory(path_, ignored);
    throw IoError(path_.string(), fmt::format("has no depth images ({}){}", imageEndings(),
                                              is_folder ? "; " + foundIn(path_) : ""));
  }
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

}  // namespace facetloc::internal
