// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/sequence_reader.h"

#include <facetloc/io/error.h>
#include <facetloc/io/segment_file.h>

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <map>
#include <system_error>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

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
RecordingLayout layoutOf(const ImageContainer& container, const fs::path& path,
                         const std::vector<fs::path>& beside) {
  std::vector<ListedImage> images;
  bool ascending = true;
  for (std::size_t i = 0; i < container.size(); ++i) {
    images.push_back({path, container.stamp(i)});
    ascending = ascending && (i == 0 || images[i].stamp > images[i - 1].stamp);
  }
  if (ascending) return layoutOf(images, beside);
  RecordingLayout layout;
  for (std::size_t i = 0; i < images.size(); ++i)
    layout.frames.push_back({fmt::format("frame_{}", i), path, static_cast<double>(i)});
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
  const bool is_folder = fs::is_directory(path_, ignored);
  asked_ = is_folder ? fs::absolute(path_) : fs::absolute(path_).parent_path();
  const bool has_depth = is_folder && fs::is_directory(path_ / "depth", ignored);
  const fs::path images = has_depth ? path_ / "depth" : path_;
  beside_ = placesBeside(has_depth ? images : asked_, asked_);
  if (is_folder)
    layout_ = layoutOf(imagesOfFolder(images), beside_);
  else if (isImage(path_))
    layout_ = layoutOf({{path_}}, beside_);
  else if (isImageList(path_))
    layout_ = layoutOf(imagesOfList(path_), beside_);
  else if (isContainer(path_))
    layout_ = layoutOf(*(container_ = openContainer(path_, hints_.topic)), path_, beside_);
  else
    throw IoError(path_.string(),
                  "is no sequence: expected a folder, a .png, a .pcd, an .oni or .bag recording, "
                  "or a list in a .txt or .lst file");
}

bool SequenceReader::hasPngs() const {
  return std::any_of(layout_.frames.begin(), layout_.frames.end(),
                     [](const FrameFile& frame) { return isPng(frame.path); });
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
  if (is_file)
    camera = RecordedCamera{readCameraFile(hints_.camera)};
  else
    camera = cameraOf(layout_, beside_, asked_);
  if (!camera && container_) camera = RecordedCamera{container_->camera()};
  if (!hints_.camera.empty() && !is_file) camera = withPreset(hints_.camera, camera, layout_);
  if (camera && hints_.depth_scale > 0) camera->file.depth_scale = hints_.depth_scale;
  return camera;
}

DepthSequence SequenceReader::readWithoutCamera() const {
  return readWith(cameraOf(layout_, beside_, asked_));  // which may say where its y axis points
}

DepthSequence SequenceReader::readWith(std::optional<RecordedCamera> camera) const {
  DepthSequence sequence;
  sequence.frames_ = layout_.frames;
  sequence.stamped_ = layout_.stamped;
  sequence.container_ = container_;
  sequence.layout_ = container_ ? "a recording in one file" : layout_.inWords();
  sequence.time_offset_ = hints_.time_offset;
  if (camera) {
    sequence.camera_ = std::move(camera->file);
    sequence.camera_remark_ = std::move(camera->remark);
  }
  try {
    sequence.ground_truth_ = sequence.asOfImages(layout_.poses.read());
  } catch (const IoError&) {  // of no matter to those who do not ask for poses
    sequence.ground_truth_fault_ = std::current_exception();
  }
  return sequence;
}

DepthSequence SequenceReader::read() const {
  if (layout_.frames.empty()) throw IoError(path_.string(), "has no .png or .pcd depth images");
  if (hints_.depth_scale > 0 && !hasPngs())
    throw IoError(path_.string(), "has no PNG images, whose values a depth scale would explain");
  const bool of_segments = hasSegments();
  if (of_segments && !hints_.segments)
    throw IoError(
        path_.string(),
        "holds segments, which facetloc_localize, facetloc_register and facetloc_render take; here, "
        "the depth images are needed that they were found in");
  DepthSequence sequence = readWith(camera());
  sequence.of_segments_ = of_segments;
  if (!sequence.camera() && hasPngs()) throw IoError(path_.string(), adviceOnCamera(layout_, asked_));
  return sequence;
}

}  // namespace facetloc::internal
