// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"
#include "images/depth_file.h"
#include "recordings/recording_layout.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/pclzf.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>

namespace facetloc::internal {
namespace {

constexpr const char* kCameraFile = "camera.ini";
constexpr const char* kMatrices[] = {"camera-intrinsics.txt", "intrinsic/intrinsic_depth.txt"};
constexpr double kTum = 5000;  // PNG values per metre of TUM's recordings

/** A camera of a public data set. */
struct KnownCamera {
  const char* title;
  const char* folder;  // a part of its recordings' path; empty = any
  RecordingLayout::Kind kind;
  Intrinsics intrinsics;
  double depth_scale;
  const char* preset;
  bool y_axis_up = false;
};

using Kind = RecordingLayout::Kind;
const KnownCamera kKnown[] = {
    {"TUM RGB-D", "freiburg1", Kind::plain, {640, 480, 517.3, 516.5, 318.6, 255.3}, kTum, "kinect"},
    {"TUM RGB-D", "freiburg2", Kind::plain, {640, 480, 520.9, 521.0, 325.1, 249.7}, kTum, "kinect"},
    {"TUM RGB-D", "freiburg3", Kind::plain, {640, 480, 535.4, 539.2, 320.1, 247.6}, kTum, "xtion"},
    {"7-Scenes", "", Kind::seven_scenes, {640, 480, 585, 585, 320, 240}, kMillimetres, "kinect"},
    {"ICL-NUIM", "", Kind::icl_nuim, {640, 480, 481.2, 480, 319.5, 239.5}, kTum, "kinect", true},
};

/** Size of the first readable depth image; empty without one. */
std::optional<PngSize> sizeOfImages(const RecordingLayout& layout) {
  for (const FrameFile& frame : layout.frames)
    if (isDepthFile(frame.path))
      if (const auto size = depthFileSize(frame.path)) return size;
  return {};
}

/** 3x3, or 4x4 with the same in its corner. */
Intrinsics readMatrix(const fs::path& path, const PngSize& size) {
  const std::vector<double> m = numbersOf(files::readText(path), path);
  const std::size_t columns = m.size() == 9 ? 3 : 4;
  if (m.size() != columns * columns)
    throw IoError(path.string(),
                  fmt::format("has {} numbers, which are not a matrix of 3x3 or 4x4", m.size()));
  const Intrinsics intrinsics{size.width, size.height, m[0], m[columns + 1], m[2], m[columns + 2]};
  if (!intrinsics.valid()) throw IoError(path.string(), "its matrix is not a camera matrix");
  return intrinsics;
}

bool mentions(const fs::path& path, const std::string& word) {
  return path.string().find(word) != std::string::npos;
}

std::optional<RecordedCamera> knownCamera(const RecordingLayout& layout, const PngSize& size,
                                          const fs::path& asked) {
  for (const KnownCamera& known : kKnown) {
    const bool fits = known.kind == layout.kind && mentions(asked, known.folder) &&
                      size.width == known.intrinsics.width && size.height == known.intrinsics.height;
    if (!fits) continue;
    RecordedCamera camera{cameraFileOf(known.intrinsics, known.depth_scale, *findCameraPreset(known.preset))};
    camera.file.y_axis_up = known.y_axis_up;
    camera.remark = fmt::format("there is no camera.ini: the camera is taken to be the one of {}{}{}",
                                known.title, *known.folder ? ", " : "", known.folder);
    return camera;
  }
  return {};
}

/** "640x480, 848x480". */
std::string modesOf(const CameraPreset& preset) {
  std::string words;
  for (const Intrinsics& mode : preset.modes)
    words += fmt::format("{}{}x{}", words.empty() ? "" : ", ", mode.width, mode.height);
  return words;
}

RecordedCamera presetCamera(const CameraPreset& preset, const std::optional<RecordedCamera>& recorded,
                            const RecordingLayout& layout) {
  const auto size = sizeOfImages(layout);
  if (recorded) {
    RecordedCamera camera = *recorded;
    const Camera usual = preset.camera();
    camera.file.camera.noise = usual.noise;
    camera.file.camera.max_depth = usual.max_depth;
    camera.file.preset = preset.name;
    return camera;
  }
  // Clouds have their intrinsics in them, which a camera without any leaves as they are.
  if (!size) return {cameraFileOf({}, kMillimetres, preset)};
  const auto intrinsics = preset.intrinsicsOf(size->width, size->height);
  if (!intrinsics)
    throw IoError(
        layout.frames.front().path.string(),
        fmt::format("is of {}x{} pixels, but the intrinsics of {} are known for {} and images of the "
                    "same shape only: write a camera.ini with the calibration",
                    size->width, size->height, preset.name, modesOf(preset)));
  return {cameraFileOf(*intrinsics, kMillimetres, preset),
          std::string("there is no calibration: the intrinsics are taken to be those of a typical ") +
              preset.name};
}

/** Camera of PCL's recorders, which write frame_<time>.xml along with frame_<time>_depth.pclzf. */
std::optional<RecordedCamera> cameraOfPclzf(const RecordingLayout& layout, const PngSize& size) {
  const fs::path& image = layout.frames.front().path;
  if (lowerExtension(image) != ".pclzf") return {};
  const std::string name = image.stem().string();
  const fs::path file = image.parent_path() / (name.substr(0, name.rfind('_')) + ".xml");
  if (!fs::is_regular_file(file)) return {};
  const PclzfCamera camera = readPclzfCamera(file, size.width, size.height);
  return RecordedCamera{cameraFileOf(camera.intrinsics, camera.depth_scale, cameraPresets().front())};
}

bool isCalibration(const fs::path& file) {
  const std::string extension = lowerExtension(file);
  return extension == ".yaml" || extension == ".yml" || extension == ".json";
}

/** Those of folders, and the first one of each folder below that is called calib or the like. */
std::vector<fs::path> calibrationsIn(const std::vector<fs::path>& folders) {
  std::vector<fs::path> found;
  const auto add = [&found](const fs::path& folder, bool all) {
    constexpr std::size_t kMost = 20;
    std::vector<fs::path> some = files::entriesOf(
        folder, [](const auto& entry) { return isCalibration(entry.path()) && files::isFile(entry); });
    some.resize(std::min(some.size(), all ? kMost : 1));
    found.insert(found.end(), some.begin(), some.end());
  };
  for (const fs::path& folder : folders) {
    add(folder, true);
    const auto isOfCalibrations = [](const auto& entry) {
      const fs::path name = entry.path().filename();
      return files::isFolder(entry) && (mentions(name, "calib") || mentions(name, "intrinsic"));
    };
    for (const fs::path& below : files::entriesOf(folder, isOfCalibrations)) add(below, false);
  }
  return found;
}

/** Could it be the camera of images of this size? Its centre is near the middle of these. */
bool isCentred(const Intrinsics& k, const PngSize& size) {
  const auto isNear = [](double c, int side) { return c > 0.25 * side && c < 0.75 * side; };
  return isNear(k.cx, size.width) && isNear(k.cy, size.height);
}

/** Phones have images of confidence. */
bool isPhone(const std::vector<fs::path>& within) {
  const auto isConfidence = [](const auto& entry) {
    return entry.path().filename().string().rfind("conf", 0) == 0;
  };
  return std::any_of(within.begin(), within.end(),
                     [&](const fs::path& folder) { return !files::entriesOf(folder, isConfidence).empty(); });
}

/** Size by the frame header of a JPEG; empty without one. */
std::optional<PngSize> jpegSize(const fs::path& path) {
  const std::string bytes = files::readBytes(path);
  const auto at = [&bytes](std::size_t i) -> std::size_t {
    return i < bytes.size() ? static_cast<std::uint8_t>(bytes[i]) : 0;
  };
  const auto wordAt = [&at](std::size_t i) { return at(i) << 8 | at(i + 1); };
  for (std::size_t i = 2; at(i) == 0xFF; i += 2 + wordAt(i + 2)) {
    const std::size_t kind = at(i + 1);
    if (kind >= 0xC0 && kind <= 0xCF && kind != 0xC4 && kind != 0xC8 && kind != 0xCC)
      return PngSize{static_cast<int>(wordAt(i + 7)), static_cast<int>(wordAt(i + 5)), 8};
  }
  return {};
}

/** Size of the colour image with the name of a calibration; empty without one. */
std::optional<PngSize> sizeOfColour(fs::path file) try {
  for (const char* ending : {".jpg", ".jpeg", ".JPG"})
    if (fs::is_regular_file(file.replace_extension(ending))) return jpegSize(file);
  return pngSize(file.replace_extension(".png"));
} catch (const IoError&) {
  return {};
}

/** The same image with other numbers of pixels? */
bool isSameShape(const Intrinsics& k, const PngSize& size) {
  return std::abs(static_cast<double>(k.width) * size.height - static_cast<double>(k.height) * size.width) <=
         std::max(k.width, k.height);
}

/** Depth camera by the colour images of a phone: its depth images show the same with fewer pixels.
 * \param colour of unknown size: width 0 */
RecordedCamera phoneCamera(const Intrinsics& colour, const PngSize& size, const fs::path& file) {
  constexpr double kColourWidths[] = {1920, 1440, 1280, 640};
  double width = colour.width > 0 ? colour.width : kColourWidths[0];
  if (colour.width == 0)  // the centre is near the middle
    for (const double w : kColourWidths)
      if (std::abs(w - 2 * colour.cx) < std::abs(width - 2 * colour.cx)) width = w;
  const double scale = size.width / width;
  const auto centre = [scale](double c) { return (c + 0.5) * scale - 0.5; };
  const Intrinsics k{size.width,        size.height,       scale * colour.fx,
                     scale * colour.fy, centre(colour.cx), centre(colour.cy)};
  if (!k.valid() || !isCentred(k, size))
    throw IoError(file.string(), "its camera has images of another size");
  return {
      cameraFileOf(k, kMillimetres, *findCameraPreset("phone_lidar")),
      fmt::format("there is no camera.ini: the intrinsics are those of {} for colour images of {} columns, "
                  "depths are millimetres, the noise a phone's",
                  file.string(), width)};
}

/** Camera of Stray Scanner, by the matrix of the colour images. */
std::optional<RecordedCamera> cameraOfStrayScanner(const PngSize& size, const std::vector<fs::path>& within) {
  const auto file = findIn(within, "camera_matrix.csv");
  if (!file) return {};
  std::string content = files::readText(*file);
  std::replace(content.begin(), content.end(), ',', ' ');
  const std::vector<double> m = numbersOf(content, *file);
  if (m.size() != 9) throw IoError(file->string(), "is no matrix of 3x3");
  return phoneCamera({0, 0, m[0], m[4], m[2], m[5]}, size, *file);
}

/** Camera of the first calibration for images of this size. */
std::optional<RecordedCamera> calibratedCamera(const PngSize& size, const std::vector<fs::path>& calibrations,
                                               bool is_phone) {
  for (const fs::path& file : calibrations) {
    auto found = parseCalibration(files::readText(file), file.string());
    if (!found) continue;
    Intrinsics& k = found->intrinsics;
    const bool no_size = k.width == 0 && k.height == 0;
    auto colour = no_size && found->of_scanner ? sizeOfColour(file) : std::nullopt;
    if (colour && !isCentred(k, *colour)) colour.reset();  // a smaller picture of it
    if (colour) k.width = colour->width, k.height = colour->height;
    const bool is_known = !no_size || colour;
    const bool is_other = is_known ? k.width != size.width : !isCentred(k, size);
    if (is_other && (is_known ? found->of_scanner && isSameShape(k, size) : is_phone || found->of_scanner)) {
      RecordedCamera camera = phoneCamera(k, size, file);
      camera.file.lens = found->lens;
      return camera;
    }
    if (!is_known && isCentred(k, size)) k.width = size.width, k.height = size.height;
    if (k.width != size.width || k.height != size.height) continue;
    RecordedCamera camera{
        cameraFileOf(k, found->depth_scale.value_or(kMillimetres), cameraPresets().front())};
    camera.file.lens = found->lens;
    camera.remark = fmt::format(
        "there is no camera.ini: the intrinsics{} are those of {}, depths are {}, the "
        "noise a {}'s",
        found->lens.isNone() ? "" : " and the lens", file.string(),
        found->depth_scale ? "by its scale" : "taken to be millimetres", cameraPresets().front().name);
    return camera;
  }
  return {};
}

}  // namespace

CameraFile cameraFileOf(const Intrinsics& intrinsics, double depth_scale, const CameraPreset& preset) {
  CameraFile file;
  file.camera = preset.camera();
  file.camera.intrinsics = intrinsics;
  file.depth_scale = depth_scale;
  file.preset = preset.name;
  return file;
}

std::optional<RecordedCamera> cameraOf(const RecordingLayout& layout, const std::vector<fs::path>& beside,
                                       const std::vector<fs::path>& within, const fs::path& asked) {
  if (const auto file = findIn(beside, kCameraFile)) return RecordedCamera{readCameraFile(*file)};
  const auto size = sizeOfImages(layout);
  if (!size) return {};
  for (const char* name : kMatrices)
    if (const auto matrix = findIn(beside, name)) {
      const CameraPreset& usual = cameraPresets().front();
      return RecordedCamera{cameraFileOf(readMatrix(*matrix, *size), kMillimetres, usual),
                            fmt::format("there is no camera.ini: the intrinsics are those of {}, depths are "
                                        "taken to be millimetres, the noise a {}'s",
                                        matrix->string(), usual.name)};
    }
  if (auto camera = cameraOfPclzf(layout, *size)) return camera;
  if (auto camera = cameraOfStrayScanner(*size, within)) return camera;
  std::vector<fs::path> calibrations = calibrationsIn(within);
  if (const auto of_replica = findIn(beside, "cam_params.json")) calibrations.push_back(*of_replica);
  if (auto camera = calibratedCamera(*size, calibrations, isPhone(within))) return camera;
  return knownCamera(layout, *size, asked);
}

RecordedCamera withPreset(const std::string& name, const std::optional<RecordedCamera>& recorded,
                          const RecordingLayout& layout) {
  if (const CameraPreset* preset = findCameraPreset(name)) return presetCamera(*preset, recorded, layout);
  throw IoError(name, fmt::format("is neither the file of a camera nor the name of one (known: {})",
                                  cameraPresetNames()));
}

std::string adviceOnCamera(const RecordingLayout& layout, const fs::path& asked) {
  const Intrinsics& kinect = cameraPresets().front().intrinsics();
  const PngSize size = sizeOfImages(layout).value_or(PngSize{kinect.width, kinect.height});
  const CameraPreset& preset = cameraPresetFor(size.width, size.height);
  const auto of_device = preset.intrinsicsOf(size.width, size.height);
  Intrinsics k = of_device.value_or(kinect);
  if (!of_device) {  // camera unknown: with a Kinect's field of view
    const double f = kinect.fx * size.width / kinect.width;
    k = {size.width, size.height, f, f, (size.width - 1) / 2.0, (size.height - 1) / 2.0};
  }
  return fmt::format(
      "depth images need to know their camera. "
      "Write the file {file} with its calibration; of a typical {camera}{mode}, it would be\n"
      "  width={width}  height={height}\n"
      "  fx={fx}  fy={fy}  cx={cx}  cy={cy}\n"
      "  depth_scale=1000    # PNG values per metre; 5000 in TUM's recordings\n"
      "{key}"
      "or name the camera, for the intrinsics of a typical device: --camera NAME, one of {names}",
      fmt::arg("file", (asked / kCameraFile).lexically_normal().string()), fmt::arg("camera", preset.name),
      fmt::arg("mode", of_device ? "" : ", which has no images of this size"), fmt::arg("width", size.width),
      fmt::arg("height", size.height), fmt::arg("fx", text::shortest(std::round(k.fx))),
      fmt::arg("fy", text::shortest(std::round(k.fy))),
      fmt::arg("cx", text::shortest(std::round(10 * k.cx) / 10)),
      fmt::arg("cy", text::shortest(std::round(10 * k.cy) / 10)),
      fmt::arg("key", of_device ? fmt::format("  camera={}\n", preset.name) : std::string()),
      fmt::arg("names", cameraPresetNames()));
}

}  // namespace facetloc::internal
