// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/camera_file.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr double kPositive = std::numeric_limits<double>::min();
constexpr double kLargestSide = 65535;  // [px]
constexpr double kLargest = 1e6;        // bound of focal lengths and centres [px], generously
constexpr double kLargestLens = 1e4;    // bound of coefficients of a lens, generously

/** Numbers of a file; null for one of a mounting that it lacks. */
using Field = double* (*)(CameraFile& file);
template <auto Member>
double* lens(CameraFile& file) {
  return &(file.lens.*Member);
}
template <auto Member>
double* mounted(CameraFile& file) {
  return file.camera.mounting ? &((*file.camera.mounting).*Member) : nullptr;
}
template <auto Member>
double* noise(CameraFile& file) {
  return &(file.camera.noise.*Member);
}
double* maxDepth(CameraFile& file) { return &file.camera.max_depth; }

enum class Kind { whole, required, optional };  // whole numbers are required

struct Key {
  std::string_view name;
  double lowest, highest;
  Field field = nullptr;
  Kind kind = Kind::optional;
};

/** The order is the one of written files. */
constexpr Key kKeys[] = {
    {"width", 1, kLargestSide, nullptr, Kind::whole},
    {"height", 1, kLargestSide, nullptr, Kind::whole},
    {"fx", kPositive, kLargest, nullptr, Kind::required},
    {"fy", -kLargest, kLargest, nullptr, Kind::required},
    {"cx", -kLargest, kLargest, nullptr, Kind::required},
    {"cy", -kLargest, kLargest, nullptr, Kind::required},
    {"depth_scale", kPositive, 1e9, nullptr, Kind::required},
    {"k1", -kLargestLens, kLargestLens, lens<&LensDistortion::k1>},
    {"k2", -kLargestLens, kLargestLens, lens<&LensDistortion::k2>},
    {"k3", -kLargestLens, kLargestLens, lens<&LensDistortion::k3>},
    {"k4", -kLargestLens, kLargestLens, lens<&LensDistortion::k4>},
    {"k5", -kLargestLens, kLargestLens, lens<&LensDistortion::k5>},
    {"k6", -kLargestLens, kLargestLens, lens<&LensDistortion::k6>},
    {"p1", -kLargestLens, kLargestLens, lens<&LensDistortion::p1>},
    {"p2", -kLargestLens, kLargestLens, lens<&LensDistortion::p2>},
    {"mount_height", 0, 100, mounted<&CameraMounting::height>},
    {"mount_tilt_deg", -90, 90, mounted<&CameraMounting::tilt_deg>},
    {"mount_roll_deg", -180, 180, mounted<&CameraMounting::roll_deg>},
    {"mount_pan_deg", -180, 180, mounted<&CameraMounting::pan_deg>},
    {"mount_x", -100, 100, mounted<&CameraMounting::x>},
    {"mount_y", -100, 100, mounted<&CameraMounting::y>},
    {"inverse_depth_std", DepthNoise::kLeastInverseDepthStd, DepthNoise::kLargestInverseDepthStd,
     noise<&SensorNoise::inverse_depth_std>},
    {"depth_std", 0, DepthNoise::kLargestDepthStd, noise<&SensorNoise::depth_std>},
    {"depth_std_slope", 0, DepthNoise::kLargestDepthStdSlope, noise<&SensorNoise::depth_std_slope>},
    {"distortion_offset", 0, 1, noise<&SensorNoise::distortion_offset>},
    {"distortion_slope", 0, 1, noise<&SensorNoise::distortion_slope>},
    {"correlation_px", 0, SensorNoise::kLargestCorrelation, noise<&SensorNoise::correlation_px>},
    {"max_depth", 0.1, 1e3, maxDepth},
};
constexpr std::string_view kPreset = "camera", kDepthIs = "depth_is";  // the keys whose values are words
constexpr std::string_view kZ = "z", kDistance = "distance";

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

/** The camera of the preset, or without a preset, the default. */
Camera usualCamera(const CameraPreset* preset) { return preset ? preset->camera() : Camera(); }

class Parser {
public:
  explicit Parser(std::string path) : path_(std::move(path)) {}

  CameraFile parse(const CameraKeys& pairs) {
    for (const auto& [key, value] : pairs) store(key, value);
    return cameraFile();
  }
  CameraFile parse(std::string_view content) {
    for (const std::string_view line : text::lines(content)) {
      ++line_;
      parseLine(text::lower(spaced(text::withoutComment(line))));
    }
    return cameraFile();
  }

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
    if (!(*value >= key->lowest && *value <= key->highest) ||
        (key->kind == Kind::whole && *value != std::floor(*value)) || (name == "fy" && *value == 0))
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
    if (key.kind != Kind::optional) return {};
    return fmt::format(": it must lie in [{}, {}], or the key be left out", text::shortest(key.lowest),
                       text::shortest(key.highest));
  }

  void requireComplete() const {
    for (const Key& key : kKeys)
      if (key.kind != Kind::optional && !values_.count(key.name))
        throw IoError(path_, fmt::format("has no {}", key.name));
    constexpr double kMostOblong = 2;  // aspect of a pixel, whichever way the y axis points
    const double fy = values_.at("fy");
    if (fy < 0 && !(-fy <= kMostOblong * values_.at("fx") && -fy >= values_.at("fx") / kMostOblong))
      throw IoError(path_, fmt::format("fy = {} is impossible", text::shortest(fy)));
    if (values_.count("mount_height") != values_.count("mount_tilt_deg"))
      throw IoError(path_, "has only one of mount_height and mount_tilt_deg");
    for (const Key& key : kKeys)
      if (key.name.rfind("mount_", 0) == 0 && values_.count(key.name) && !values_.count("mount_height"))
        throw IoError(path_, fmt::format("has {}, but not mount_height and mount_tilt_deg", key.name));
  }

  CameraFile cameraFile() const {
    requireComplete();
    const Values& v = values_;
    CameraFile file;
    file.camera = usualCamera(preset_);
    if (preset_) file.preset = preset_->name;
    file.y_axis_up = v.at("fy") < 0;
    file.camera.intrinsics = {static_cast<int>(v.at("width")),
                              static_cast<int>(v.at("height")),
                              v.at("fx"),
                              std::abs(v.at("fy")),
                              v.at("cx"),
                              v.at("cy")};
    file.depth_scale = v.at("depth_scale");
    if (v.count("mount_height")) file.camera.mounting.emplace();
    for (const auto& [name, value] : v)
      if (const Field field = findKey(name)->field) *field(file) = value;
    file.depth_is = depth_kind_.value_or(DepthKind::z);
    return file;
  }

  std::string path_;
  int line_ = 0;
  Values values_;
  const CameraPreset* preset_ = nullptr;
  std::optional<DepthKind> depth_kind_;
};

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
  return Parser(name).parse(keys);
}

CameraFile readCameraFile(const fs::path& path) { return Parser(path.string()).parse(files::readText(path)); }

CameraKeys keysOfCamera(const CameraFile& file) {
  const Camera& camera = file.camera;
  if (!camera.intrinsics.valid() || !(file.depth_scale > 0))
    throw std::invalid_argument("keysOfCamera: the camera is impossible");
  const CameraPreset* preset = findCameraPreset(file.preset);
  if (!file.preset.empty() && !preset)
    throw std::invalid_argument("keysOfCamera: there is no camera " + file.preset);
  CameraFile written = file, usual;
  usual.camera = usualCamera(preset);
  if (camera.mounting)
    usual.camera.mounting = CameraMounting{NAN, NAN};  // which are written, whatever they are
  const Intrinsics& k = camera.intrinsics;
  CameraKeys keys = {{"width", std::to_string(k.width)}, {"height", std::to_string(k.height)}};
  const auto add = [&keys](std::string_view key, double value) {
    keys.emplace_back(key, text::shortest(value));
  };
  add("fx", k.fx), add("fy", file.y_axis_up ? -k.fy : k.fy), add("cx", k.cx), add("cy", k.cy);
  add("depth_scale", file.depth_scale);
  for (const Key& key : kKeys) {
    if (key.name == "mount_height" && file.depth_is == DepthKind::distance)
      keys.emplace_back(kDepthIs, kDistance);
    if (key.name == "inverse_depth_std" && preset) keys.emplace_back(kPreset, preset->name);
    const double* value = key.field ? key.field(written) : nullptr;
    if (value && *value != *key.field(usual)) add(key.name, *value);
  }
  return keys;
}

void writeCameraFile(const fs::path& path, const CameraFile& camera) {
  const CameraKeys keys = keysOfCamera(camera);
  writeTextAtomically(path, [&](std::ostream& out) {
    for (const auto& [key, value] : keys) out << key << "=" << value << "\n";
  });
}

}  // namespace facetloc
