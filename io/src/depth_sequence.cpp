// SPDX-License-Identifier: BSD-3-Clause
#include "files.h"
#include "pcd_header.h"

#include <facetloc/features/organized_cloud.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/oni_file.h>
#include <facetloc/io/png.h>
#include <facetloc/io/text.h>

#include <pcl/PCLPointCloud2.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCameraFile = "camera.ini";
constexpr const char* kGroundTruthFile = "groundtruth.txt";
constexpr int kStampDigits = 6;  // of the frames of a recording: microseconds

std::string lowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

bool isPng(const fs::path& path) { return lowerExtension(path) == ".png"; }
bool isPcd(const fs::path& path) { return lowerExtension(path) == ".pcd"; }
bool isRecording(const fs::path& path) { return lowerExtension(path) == ".oni"; }
bool isImage(const fs::path& path) { return isPng(path) || isPcd(path); }
bool isList(const fs::path& path) { return lowerExtension(path) == ".txt" || lowerExtension(path) == ".lst"; }

FrameFile frameOf(const fs::path& path) { return {path.stem().string(), path, 0}; }

/** Sorted by name, since a folder lists its files in any order. */
std::vector<FrameFile> framesOfFolder(const fs::path& folder) {
  std::vector<FrameFile> frames;
  try {
    for (const auto& entry : fs::directory_iterator(folder)) {
      const bool hidden = entry.path().filename().string().front() == '.';
      // A link that leads nowhere is an image that cannot be read.
      if (!hidden && isImage(entry.path()) && !entry.is_directory()) frames.push_back(frameOf(entry.path()));
    }
  } catch (const fs::filesystem_error& e) {
    throw IoError(folder.string(), e.what());
  }
  std::sort(frames.begin(), frames.end(),
            [](const FrameFile& a, const FrameFile& b) { return a.path < b.path; });
  return frames;
}

std::vector<FrameFile> framesOfList(const fs::path& list) {
  const std::string content = files::readText(list);
  std::vector<FrameFile> frames;
  int number = 0;
  for (const std::string_view line : text::lines(content)) {
    ++number;
    const auto entry = text::trimmed(line);
    if (entry.empty() || entry.front() == '#') continue;
    const fs::path path = list.parent_path() / fs::path(entry);  // an absolute entry stays as it is
    if (!isImage(path))
      throw IoError(list.string(), "line " + std::to_string(number) + ": " + std::string(entry) +
                                       " is neither a .png nor a .pcd file");
    frames.push_back(frameOf(path));  // one that is missing fails when it is read, and stops no other
  }
  return frames;
}

void requireUniqueNames(const std::vector<FrameFile>& frames, const fs::path& source) {
  std::map<std::string, fs::path> seen;
  for (const FrameFile& frame : frames) {
    const auto [other, is_new] = seen.emplace(frame.name, frame.path);
    if (!is_new)
      throw IoError(source.string(), "two frames have the name " + text::quoted(frame.name) + ": " +
                                         other->second.string() + " and " + frame.path.string());
  }
}

bool isStamp(const std::string& name) {
  return std::isfinite(text::to<double>(name).value_or(std::numeric_limits<double>::quiet_NaN()));
}

/** Stamps from the names if they are numbers, and then in their order; else the index, in the given order.
 * One stray name among stamps is an error: it would silently turn all stamps into indices. False for indices.
 */
bool stampFrames(std::vector<FrameFile>& frames) {
  const auto stray =
      std::find_if(frames.begin(), frames.end(), [](const FrameFile& f) { return !isStamp(f.name); });
  const bool numbers = stray == frames.end();
  if (!numbers &&
      std::any_of(frames.begin(), frames.end(), [](const FrameFile& f) { return isStamp(f.name); }))
    throw IoError(stray->path.string(), "its name is no time stamp, unlike those of other images beside it");
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i].stamp = numbers ? *text::to<double>(frames[i].name) : static_cast<double>(i);
  std::stable_sort(frames.begin(), frames.end(),
                   [](const FrameFile& a, const FrameFile& b) { return a.stamp < b.stamp; });
  return numbers;
}

/** The first file of this name in the folder of the images, its parent, or the folder that was asked for and
 * its parent. Of a folder that is a link, the parent is where the link is, and else where the folder is. */
std::optional<fs::path> findBeside(const fs::path& images, const fs::path& asked, const char* name) {
  for (const fs::path& folder : {images, images / "..", asked, asked / ".."})
    for (const fs::path& file : {(folder / name).lexically_normal(), folder / name})
      if (fs::is_regular_file(file)) return file;
  return {};
}

/** An image of another size was not taken with this camera. */
void requireSize(const fs::path& path, int width, int height, const Intrinsics& camera) {
  if (width == camera.width && height == camera.height) return;
  const auto size = [](int w, int h) { return std::to_string(w) + "x" + std::to_string(h); };
  throw IoError(path.string(), "is of " + size(width, height) + " pixels, but the camera of " +
                                   size(camera.width, camera.height));
}

/** What a recording tells of its camera. */
CameraFile cameraOf(const OniFile& recording) {
  if (!recording.camera().valid())
    throw IoError(recording.path().string(),
                  "does not tell the field of view of its camera; a camera.ini beside it would");
  CameraFile file;
  file.camera.intrinsics = recording.camera();
  file.depth_scale = 1000 / recording.millimetres();
  return file;
}

}  // namespace

DepthSequence DepthSequence::open(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw IoError(path.string(), "does not exist");
  const bool is_folder = fs::is_directory(path, ignored);
  const fs::path asked = is_folder ? fs::absolute(path) : fs::absolute(path).parent_path();
  const fs::path images = is_folder && fs::is_directory(path / "depth", ignored) ? path / "depth" : asked;

  DepthSequence sequence;
  const bool is_recording = !is_folder && isRecording(path);
  if (is_folder)
    sequence.frames_ = framesOfFolder(images == asked ? path : images);
  else if (isImage(path))
    sequence.frames_ = {frameOf(path)};
  else if (is_recording)
    sequence.openRecording(path);
  else if (isList(path))
    sequence.frames_ = framesOfList(path);
  else
    throw IoError(path.string(), "is no sequence: expected a folder, a .png, a .pcd, an .oni recording or a "
                                 "list in a .txt or .lst file");
  if (sequence.frames_.empty()) throw IoError(path.string(), "has no .png or .pcd depth images");
  requireUniqueNames(sequence.frames_, path);
  sequence.stamped_ = stampFrames(sequence.frames_);

  if (const auto file = findBeside(images, asked, kCameraFile)) sequence.camera_ = readCameraFile(*file);
  // Indices are no times: poses would be matched to them at random.
  if (const auto file = findBeside(images, asked, kGroundTruthFile); file && sequence.stamped_) {
    try {
      sequence.ground_truth_ = readTumTrajectory(*file);
    } catch (const IoError&) {  // of no matter to those who do not ask for poses
      sequence.ground_truth_fault_ = std::current_exception();
    }
  }
  const bool needs_camera = std::any_of(sequence.frames_.begin(), sequence.frames_.end(),
                                        [](const FrameFile& frame) { return isPng(frame.path); });
  if (needs_camera && !sequence.camera_)
    throw IoError(path.string(), std::string("PNG images need a camera.ini beside ") +
                                     (isList(path) ? "their list" : "them") + " or in the folder above");
  if (is_recording && !sequence.camera_) sequence.camera_ = cameraOf(*sequence.recording_);
  return sequence;
}

/** Named by their stamps, as images of the TUM format; by their numbers if the stamps do not tell them apart.
 */
void DepthSequence::openRecording(const fs::path& path) {
  recording_ = std::make_shared<const OniFile>(OniFile::open(path));
  bool ascending = true;
  for (std::size_t i = 1; i < recording_->size(); ++i)
    ascending = ascending && recording_->stamp(i) > recording_->stamp(i - 1);
  for (std::size_t i = 0; i < recording_->size(); ++i) {
    const std::string number = "frame_" + std::to_string(i);
    frames_.push_back({ascending ? text::decimals(recording_->stamp(i), kStampDigits) : number, path, 0});
  }
}

const Trajectory& DepthSequence::groundTruth() const {
  if (ground_truth_fault_) std::rethrow_exception(ground_truth_fault_);
  return ground_truth_;
}

std::string DepthSequence::remark() const {
  if (!recording_ || recording_->finished()) return {};
  return recording_->path().string() + ": the recording was never finished; it is read as far as it goes, " +
         std::to_string(frames_.size()) + " frames";
}

DepthImage DepthSequence::load(std::size_t index, int working_width) const {
  const fs::path& path = frames_.at(index).path;
  DepthImage image;
  if (recording_) {
    image = recording_->read(index);
    requireSize(path, image.camera.width, image.camera.height, camera_->camera.intrinsics);
    image.camera = camera_->camera.intrinsics;
  } else if (isPng(path))
    image = readDepthPng(path, *camera_);
  else
    image = readDepthPcd(path, camera_ ? std::optional(camera_->camera.intrinsics) : std::nullopt);
  const int step = working_width > 0 ? subsamplingStep(image.camera, working_width) : 1;
  return step > 1 ? subsampled(image, step) : image;
}

DepthImage readDepthPng(const std::filesystem::path& path, const CameraFile& file) {
  constexpr int kBits = 16;
  const Raster<std::uint16_t> raster = readGreyPng(path, kBits);
  const Intrinsics& intrinsics = file.camera.intrinsics;
  requireSize(path, raster.width, raster.height, intrinsics);
  DepthImage image{intrinsics, std::vector<float>(raster.data.size())};
  std::transform(raster.data.begin(), raster.data.end(), image.depth.begin(),
                 [&](std::uint16_t value) { return static_cast<float>(value / file.depth_scale); });
  return image;
}

void writeDepthPng(const std::filesystem::path& path, const DepthImage& image, double depth_scale) {
  constexpr double kLargest = std::numeric_limits<std::uint16_t>::max();
  Raster<std::uint16_t> raster{image.camera.width, image.camera.height, 1, {}};
  raster.data.resize(image.depth.size());
  std::transform(image.depth.begin(), image.depth.end(), raster.data.begin(), [&](float z) {
    const double value = std::round(z * depth_scale);
    return static_cast<std::uint16_t>(value > 0 && value <= kLargest ? value : 0);
  });
  writePng(path, raster);
}

namespace {

/** One coordinate of a cloud of any point type. */
class Coordinate {
public:
  Coordinate(const pcl::PCLPointCloud2& cloud, const char* name, const std::string& path) : cloud_(cloud) {
    const auto field = std::find_if(cloud.fields.begin(), cloud.fields.end(),
                                    [name](const pcl::PCLPointField& f) { return f.name == name; });
    if (field == cloud.fields.end()) throw IoError(path, std::string("has no field ") + name);
    is_double_ = field->datatype == pcl::PCLPointField::FLOAT64;
    if (!is_double_ && field->datatype != pcl::PCLPointField::FLOAT32)
      throw IoError(path, std::string("has a field ") + name + " that is not of floating point");
    offset_ = field->offset;
    if (offset_ + (is_double_ ? sizeof(double) : sizeof(float)) > cloud.point_step)
      throw IoError(path, "has a corrupt header");
  }
  float of(std::size_t point) const {
    const std::uint8_t* bytes = cloud_.data.data() + point * cloud_.point_step + offset_;
    return is_double_ ? static_cast<float>(as<double>(bytes)) : as<float>(bytes);
  }

private:
  template <typename T>
  static T as(const std::uint8_t* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }

  const pcl::PCLPointCloud2& cloud_;
  bool is_double_ = false;
  std::size_t offset_ = 0;
};

pcl::PCLPointCloud2 readPcd(const fs::path& path, const PcdHeader& header) {
  pcl::PCLPointCloud2 cloud;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0;
  int status = 0;
  try {
    status = pcl::PCDReader().read(path.string(), cloud, origin, orientation, version);
  } catch (const std::exception& e) {
    throw IoError(path.string(), std::string("cannot be read by PCL: ") + e.what());
  }
  const std::size_t points = std::size_t(header.width()) * header.height();
  if (status < 0 || cloud.width != static_cast<unsigned>(header.width()) ||
      cloud.data.size() != points * cloud.point_step)
    throw IoError(path.string(), "is a corrupt PCD file");
  return cloud;
}

pcl::PointCloud<pcl::PointXYZ> readOrganizedPoints(const fs::path& path) {
  const PcdHeader header(path);
  if (header.height() < 2 || header.width() < 2)
    throw IoError(path.string(), "is not an organized cloud (" + std::to_string(header.width()) + "x" +
                                     std::to_string(header.height()) + ")");
  const pcl::PCLPointCloud2 raw = readPcd(path, header);
  const Coordinate x(raw, "x", path.string()), y(raw, "y", path.string()), z(raw, "z", path.string());
  pcl::PointCloud<pcl::PointXYZ> cloud(header.width(), header.height());
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud[i] = pcl::PointXYZ(x.of(i), y.of(i), z.of(i));
  cloud.is_dense = false;
  return cloud;
}

}  // namespace

DepthImage readDepthPcd(const std::filesystem::path& path, const std::optional<Intrinsics>& camera) {
  const auto cloud = readOrganizedPoints(path);
  if (camera) {
    requireSize(path, static_cast<int>(cloud.width), static_cast<int>(cloud.height), *camera);
    if (!isImageOf(cloud, *camera, kCalibrationError * camera->width))
      throw IoError(path.string(), "its points are not where the camera of the camera.ini sees them");
    return depthImage(cloud, *camera);
  }
  const auto recovered = recoverIntrinsics(cloud);
  if (!recovered)
    throw IoError(path.string(),
                  "has too few points to recover the intrinsics from, which a camera.ini would tell, or none "
                  "of a pinhole camera at the origin");
  return depthImage(cloud, *recovered);
}

}  // namespace facetloc
