// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/camera_keys.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

constexpr double kPositive = std::numeric_limits<double>::min();
constexpr double kLargestSide = 65535;  // [px]
constexpr double kLargest = 1e6;        // bound of focal lengths and centres [px], generously
constexpr double kLargestLens = 1e4;    // bound of coefficients of a lens, generously

struct Key {
  std::string_view name;
  double lowest;
  double highest;
  bool whole;
  bool required;
};

constexpr Key kKeys[] = {
    {"width", 1, kLargestSide, true, true},
    {"height", 1, kLargestSide, true, true},
    {"fx", kPositive, kLargest, false, true},
    {"fy", -kLargest, kLargest, false, true},
    {"cx", -kLargest, kLargest, false, true},
    {"cy", -kLargest, kLargest, false, true},
    {"depth_scale", kPositive, 1e9, false, true},
    {"mount_height", 0, 100, false, false},
    {"mount_tilt_deg", -90, 90, false, false},
    {"mount_roll_deg", -180, 180, false, false},
    {"mount_pan_deg", -180, 180, false, false},
    {"mount_x", -100, 100, false, false},
    {"mount_y", -100, 100, false, false},
    {"max_depth", 0.1, 1e3, false, false},
    {"distortion_offset", 0, 1, false, false},
    {"distortion_slope", 0, 1, false, false},
    {"inverse_depth_std", DepthNoise::kLeastInverseDepthStd, DepthNoise::kLargestInverseDepthStd, false,
     false},
    {"depth_std", 0, DepthNoise::kLargestDepthStd, false, false},
    {"depth_std_slope", 0, DepthNoise::kLargestDepthStdSlope, false, false},
    {"correlation_px", 0, SensorNoise::kLargestCorrelation, false, false},
    {"k1", -kLargestLens, kLargestLens, false, false},
    {"k2", -kLargestLens, kLargestLens, false, false},
    {"k3", -kLargestLens, kLargestLens, false, false},
    {"k4", -kLargestLens, kLargestLens, false, false},
    {"k5", -kLargestLens, kLargestLens, false, false},
    {"k6", -kLargestLens, kLargestLens, false, false},
    {"p1", -kLargestLens, kLargestLens, false, false},
    {"p2", -kLargestLens, kLargestLens, false, false},
};
constexpr std::string_view kPreset = "camera", kDepthIs = "depth_is";  // the keys whose values are words
constexpr std::string_view kZ = "z", kDistance = "distance";

/** The keys of a mounting that need not be given with it, and their fields. */
struct MountingKey {
  const char* name;
  double CameraMounting::*value;
};
constexpr MountingKey kMountingKeys[] = {{"mount_roll_deg", &CameraMounting::roll_deg},
                                         {"mount_pan_deg", &CameraMounting::pan_deg},
                                         {"mount_x", &CameraMounting::x},
                                         {"mount_y", &CameraMounting::y}};

/** The keys of a camera's noise, and their fields. */
struct NoiseKey {
  const char* name;
  double SensorNoise::*value;
};
constexpr NoiseKey kNoiseKeys[] = {{"inverse_depth_std", &SensorNoise::inverse_depth_std},
                                   {"depth_std", &SensorNoise::depth_std},
                                   {"depth_std_slope", &SensorNoise::depth_std_slope},
                                   {"distortion_offset", &SensorNoise::distortion_offset},
                                   {"distortion_slope", &SensorNoise::distortion_slope},
                                   {"correlation_px", &SensorNoise::correlation_px}};

/** The keys of a lens, and their fields. */
struct LensKey {
  const char* name;
  double LensDistortion::*value;
};
constexpr LensKey kLensKeys[] = {{"k1", &LensDistortion::k1}, {"k2", &LensDistortion::k2},
                                 {"k3", &LensDistortion::k3}, {"k4", &LensDistortion::k4},
                                 {"k5", &LensDistortion::k5}, {"k6", &LensDistortion::k6},
                                 {"p1", &LensDistortion::p1}, {"p2", &LensDistortion::p2}};

using Values = std::map<std::string_view, double>;

const Key* findKey(std::string_view name) {
  for (const Key& key : kKeys)
    if (key.name == name) return &key;
  return nullptr;
}

std::string knownKeys() {
  std::string names = std::string(kPreset) + ", " + std::string(kDepthIs);
  for (const Key& key : kKeys) names.append(", ").append(key.name);
  return names;
}

/** The words of a line with every '=' as a word of its own, so that blanks around it do not matter. */
std::string spaced(std::string_view line) {
  std::string out;
  for (const char c : line) c == '=' ? out.append(" = ") : out.append(1, c);
  return out;
}

class Parser {
public:
  explicit Parser(std::string path) : path_(std::move(path)) {}

  Values parse(const CameraKeys& pairs) {
    for (const auto& [key, value] : pairs) store(key, value);
    requireComplete();
    return values_;
  }
  Values parse(std::string_view content) {
    for (const std::string_view line : text::lines(content)) {
      ++line_;
      parseLine(spaced(text::withoutComment(line)));
    }
    requireComplete();
    return values_;
  }
  /** Null if the file names none. */
  const CameraPreset* preset() const { return preset_; }
  DepthKind depthKind() const { return depth_kind_.value_or(DepthKind::z); }

private:
  [[noreturn]] void fail(const std::string& cause) const {
    throw IoError(path_, line_ > 0 ? fmt::format("line {}: {}", line_, cause) : cause);
  }

  void parseLine(const std::string& line) {
    const auto words = text::words(line);
    for (std::size_t i = 0; i < words.size(); i += 3) {
      if (i + 2 >= words.size() || words[i + 1] != "=" || words[i] == "=" || words[i + 2] == "=")
        fail("expected key = value at " + text::quoted(words[i]));
      store(words[i], words[i + 2]);
    }
  }

  void store(std::string_view name, std::string_view word) {
    if (name == kPreset) return choose(word);
    if (name == kDepthIs) return chooseKind(word);
    const Key* key = findKey(name);
    if (!key) fail(fmt::format("unknown key '{}' (known: {})", name, knownKeys()));
    const auto value = text::to<double>(word);
    if (!value) fail(fmt::format("'{}' is not a number ({})", word, name));
    if (!(*value >= key->lowest && *value <= key->highest) || (key->whole && *value != std::floor(*value)) ||
        (name == "fy" && *value == 0))
      fail(fmt::format("{} = {} is impossible{}", name, word, advice(*key)));
    if (!values_.emplace(key->name, *value).second) fail(fmt::format("{} is given twice", name));
  }

  void choose(std::string_view name) {
    if (preset_) fail(fmt::format("{} is given twice", kPreset));
    preset_ = findCameraPreset(name);
    if (!preset_)
      fail(fmt::format("unknown camera '{}' (known: {}); for another one leave the key out and set "
                       "inverse_depth_std, depth_std and depth_std_slope",
                       name, cameraPresetNames()));
  }

  void chooseKind(std::string_view word) {
    if (depth_kind_) fail(fmt::format("{} is given twice", kDepthIs));
    if (word != kZ && word != kDistance)
      fail(fmt::format("{} = {} is impossible: it is {}, the distance from the camera's plane, or {}, the "
                       "distance along the ray",
                       kDepthIs, word, kZ, kDistance));
    depth_kind_ = word == kZ ? DepthKind::z : DepthKind::distance;
  }

  /** Valid values of a number that may be left out. */
  static std::string advice(const Key& key) {
    if (key.required) return {};
    return fmt::format(": it must lie in [{}, {}], or the key be left out", text::shortest(key.lowest),
                       text::shortest(key.highest));
  }

  void requireComplete() const {
    for (const Key& key : kKeys)
      if (key.required && !values_.count(key.name)) throw IoError(path_, fmt::format("has no {}", key.name));
    constexpr double kMostOblong = 2;  // aspect of a pixel, whichever way the y axis points
    const double fy = values_.at("fy");
    if (fy < 0 && !(-fy <= kMostOblong * values_.at("fx") && -fy >= values_.at("fx") / kMostOblong))
      throw IoError(path_, fmt::format("fy = {} is impossible", text::shortest(fy)));
    if (values_.count("mount_height") != values_.count("mount_tilt_deg"))
      throw IoError(path_, "has only one of mount_height and mount_tilt_deg");
    for (const MountingKey& key : kMountingKeys)
      if (values_.count(key.name) && !values_.count("mount_height"))
        throw IoError(path_, fmt::format("has {}, but not mount_height and mount_tilt_deg", key.name));
  }

  std::string path_;
  int line_ = 0;
  Values values_;
  const CameraPreset* preset_ = nullptr;
  std::optional<DepthKind> depth_kind_;
};

/** The camera of the preset, or without a preset, the default. */
Camera usualCamera(const CameraPreset* preset) { return preset ? preset->camera() : Camera(); }

/** Camera file of parsed values. */
CameraFile cameraOf(const Parser& parser, const Values& v) {
  CameraFile file;
  if (parser.preset()) file.preset = parser.preset()->name;
  Camera& camera = file.camera;
  camera = usualCamera(parser.preset());
  file.y_axis_up = v.at("fy") < 0;
  camera.intrinsics = {static_cast<int>(v.at("width")),
                       static_cast<int>(v.at("height")),
                       v.at("fx"),
                       std::abs(v.at("fy")),
                       v.at("cx"),
                       v.at("cy")};
  file.depth_scale = v.at("depth_scale");
  if (v.count("mount_height")) camera.mounting = CameraMounting{v.at("mount_height"), v.at("mount_tilt_deg")};
  for (const auto& [name, value] : kMountingKeys)
    if (v.count(name)) (*camera.mounting).*value = v.at(name);
  for (const auto& [name, value] : kNoiseKeys)
    if (v.count(name)) camera.noise.*value = v.at(name);
  if (v.count("max_depth")) camera.max_depth = v.at("max_depth");
  for (const auto& [name, value] : kLensKeys)
    if (v.count(name)) file.lens.*value = v.at(name);
  file.depth_is = parser.depthKind();
  return file;
}

const std::string* find(const CameraKeys& keys, std::string_view name) {
  const auto found =
      std::find_if(keys.begin(), keys.end(), [&](const auto& key) { return key.first == name; });
  return found == keys.end() ? nullptr : &found->second;
}

/** Typical intrinsics of the preset that is named, if none are given. */
void addIntrinsics(CameraKeys& keys, const std::string& name) {
  if (find(keys, "fx") || find(keys, "fy") || find(keys, "cx") || find(keys, "cy")) return;
  const std::string* word = find(keys, kPreset);
  if (!word)
    throw IoError(name, "nothing is known of the camera: give fx, fy, cx and cy, or the name of a camera");
  const CameraPreset* preset = findCameraPreset(*word);
  const std::string *width = find(keys, "width"), *height = find(keys, "height");
  if (!preset || !width || !height) return;  // which the parser complains of
  const auto typical =
      preset->intrinsicsOf(text::to<int>(*width).value_or(0), text::to<int>(*height).value_or(0));
  if (!typical)
    throw IoError(name,
                  fmt::format("a {} has no images of {}x{}: give fx, fy, cx and cy", *word, *width, *height));
  for (const auto& [key, value] : {std::pair("fx", typical->fx), std::pair("fy", typical->fy),
                                   std::pair("cx", typical->cx), std::pair("cy", typical->cy)})
    keys.emplace_back(key, text::shortest(value));
}

}  // namespace

bool isCameraKey(std::string_view key) { return key == kPreset || key == kDepthIs || findKey(key); }

CameraFile cameraOfKeys(CameraKeys keys, const std::string& name) {
  constexpr const char* kMillimetres = "1000";
  if (!find(keys, "depth_scale")) keys.emplace_back("depth_scale", kMillimetres);
  addIntrinsics(keys, name);
  Parser parser(name);
  const Values values = parser.parse(keys);
  return cameraOf(parser, values);
}

CameraFile readCameraFile(const std::filesystem::path& path) {
  const std::string content = files::readText(path);
  Parser parser(path.string());
  const Values values = parser.parse(content);
  return cameraOf(parser, values);
}

void writeCameraFile(const std::filesystem::path& path, const CameraFile& file) {
  const Camera& camera = file.camera;
  if (!camera.intrinsics.valid() || !(file.depth_scale > 0))
    throw std::invalid_argument("writeCameraFile: the camera is impossible");
  const CameraPreset* preset = findCameraPreset(file.preset);
  if (!file.preset.empty() && !preset)
    throw std::invalid_argument("writeCameraFile: there is no camera " + file.preset);
  const Camera usual = usualCamera(preset);
  writeTextAtomically(path, [&](std::ostream& out) {
    const Intrinsics& k = camera.intrinsics;
    out << "width=" << k.width << "\nheight=" << k.height << "\n";
    const auto line = [&out](const char* key, double value) {
      out << key << "=" << text::shortest(value) << "\n";
    };
    line("fx", k.fx), line("fy", file.y_axis_up ? -k.fy : k.fy), line("cx", k.cx), line("cy", k.cy);
    line("depth_scale", file.depth_scale);
    for (const auto& [name, value] : kLensKeys)
      if (file.lens.*value != 0) line(name, file.lens.*value);
    if (file.depth_is == DepthKind::distance) out << kDepthIs << "=" << kDistance << "\n";
    if (camera.mounting) {
      line("mount_height", camera.mounting->height);
      line("mount_tilt_deg", camera.mounting->tilt_deg);
      for (const auto& [name, value] : kMountingKeys)
        if ((*camera.mounting).*value != 0) line(name, (*camera.mounting).*value);
    }
    if (preset) out << kPreset << "=" << preset->name << "\n";
    for (const auto& [name, value] : kNoiseKeys)
      if (camera.noise.*value != usual.noise.*value) line(name, camera.noise.*value);
    if (camera.max_depth != usual.max_depth) line("max_depth", camera.max_depth);
  });
}

}  // namespace facetloc
