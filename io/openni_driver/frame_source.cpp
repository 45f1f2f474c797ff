// SPDX-License-Identifier: BSD-3-Clause
#include "frame_source.h"

#include "base/median.h"
#include "base/text.h"
#include "bytes/files.h"

#include <facetloc/io/depth_sequence.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <set>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

constexpr int kMostFrames = 1000000;
constexpr int kSmallestWidth = 40, kLargestWidth = 2048;  // [px]
constexpr double kLargestSeed = 1e9;

std::vector<std::string> sceneNames() {
  std::vector<std::string> names = simulatedPlaceNames();
  names.push_back("room");
  return names;
}

/** Reads a .scene file. */
class Reader {
public:
  explicit Reader(const fs::path& path) : path_(path.string()) {}

  SceneFile read() {
    files::forEachLine(files::readText(path_), path_, [this](std::string_view line) {
      const auto entry = text::trimmed(text::withoutComment(line));
      if (!entry.empty()) store(entry);
    });
    if (file_.scene.empty()) throw IoError(path_, "has no scene");
    checkRanges(file_.drive), checkRanges(file_.pace), checkRanges(file_.noise);
    return file_;
  }

private:
  [[noreturn]] static void fail(const std::string& cause) { throw std::invalid_argument(cause); }

  void store(std::string_view entry) {
    const auto sign = entry.find('=');
    if (sign == std::string_view::npos) fail("expected key = value at " + text::quoted(entry));
    const std::string key(text::trimmed(entry.substr(0, sign)));
    const std::string_view word = text::trimmed(entry.substr(sign + 1));
    if (!seen_.insert(key).second) fail(key + " is given twice");
    if (key == "scene")
      file_.scene = oneOf(key, word, sceneNames());
    else if (key == "run")
      file_.run = oneOf(key, word, {"query", "map"});
    else if (key == "seed")
      file_.seed = static_cast<std::uint64_t>(number(key, word, 0.0, kLargestSeed, true));
    else if (!storeCount(key, word) && !storeField(file_.drive, key, word) &&
             !storeField(file_.pace, key, word) && !storeField(file_.noise, key, word))
      fail("unknown key " + text::quoted(key));
  }

  bool storeCount(const std::string& key, std::string_view word) {
    const auto count = [&](int& value, double lowest, double highest) {
      value = static_cast<int>(number(key, word, lowest, highest, true));
      return true;
    };
    if (key == "width") return count(file_.width, kSmallestWidth, kLargestWidth);
    if (key == "frames") return count(file_.frames, 1, kMostFrames);
    if (key == "jump_at") return count(file_.jump_at, 0, kMostFrames);
    if (key == "jump") return count(file_.jump, 0, kMostFrames);
    return false;
  }

  template <typename Params>
  bool storeField(Params& params, const std::string& key, std::string_view word) {
    bool found = false;
    forEachParam(params, [&](const ParamInfo& info, auto& value, auto lowest, auto highest) {
      using Value = std::decay_t<decltype(value)>;
      if (key != info.name.substr(info.name.rfind('.') + 1)) return;
      value = static_cast<Value>(
          number(key, word, double(lowest), double(highest), !std::is_floating_point_v<Value>));
      found = true;
    });
    return found;
  }

  double number(const std::string& key, std::string_view word, double lowest, double highest,
                bool whole) const {
    const auto value = text::to<double>(word);
    if (!value) fail(fmt::format("'{}' is not a number ({})", word, key));
    if (!(*value >= lowest && *value <= highest) || (whole && *value != static_cast<double>(int(*value))))
      fail(fmt::format("{} = {} is impossible: expected {} in [{}, {}]", key, word,
                       whole ? "a whole number" : "one", text::shortest(lowest), text::shortest(highest)));
    return *value;
  }

  std::string oneOf(const std::string& key, std::string_view word, const std::vector<std::string>& names) {
    std::string all;
    for (const std::string& name : names) {
      if (name == word) return name;
      all += " " + name;
    }
    fail(fmt::format("unknown {} '{}'; there are:{}", key, word, all));
  }

  std::string path_;
  std::set<std::string> seen_;
  SceneFile file_;
};

/** Depth in OpenNI2's unit; values out of its range become 0. */
void toMillimetres(const DepthImage& image, std::uint16_t* depth) {
  std::transform(image.depth.begin(), image.depth.end(), depth, [](float z) {
    const float millimetres = std::round(1000.f * z);
    const bool fits = isMeasured(z) && millimetres < static_cast<float>(kMaxDepthMillimetres);
    return fits ? static_cast<std::uint16_t>(millimetres) : std::uint16_t(0);
  });
}

std::uint64_t microseconds(double seconds) { return static_cast<std::uint64_t>(std::llround(1e6 * seconds)); }

constexpr int kUsualRate = 30;  // [Hz]
constexpr int kHighestRate = 1000;

/** Stamps count up by whole numbers where they are indices and not times. */
bool areTimes(const std::vector<FrameFile>& frames) {
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].stamp != static_cast<double>(i)) return frames.front().stamp >= 0;
  return false;
}

/** Rate by the median time between images, so that a gap does not count. */
int rateOf(const std::vector<FrameFile>& frames) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < frames.size(); ++i) steps.push_back(frames[i].stamp - frames[i - 1].stamp);
  if (steps.empty()) return kUsualRate;
  const double usual = internal::median(steps.begin(), steps.end());
  return usual > 0 ? static_cast<int>(std::clamp(std::round(1 / usual), 1.0, double(kHighestRate)))
                   : kUsualRate;
}

/** Camera of the first image that can be read. */
Intrinsics cameraOfImages(const DepthSequence& sequence) {
  for (std::size_t i = 0;; ++i) {
    try {
      return sequence.load(i).camera;
    } catch (const IoError&) {
      if (i + 1 == sequence.frames().size()) throw;
    }
  }
}

/** The images of a folder, at the times of their stamps; at 30 Hz if their names are no times. */
class SequenceSource : public FrameSource {
public:
  explicit SequenceSource(const std::string& folder) : sequence_(DepthSequence::open(folder)) {
    has_times_ = areTimes(sequence_.frames());
    rate_ = has_times_ ? rateOf(sequence_.frames()) : kUsualRate;
    camera_ = sequence_.camera() ? sequence_.camera()->camera.intrinsics : cameraOfImages(sequence_);
    if (sequence_.camera()) mounting_ = sequence_.camera()->camera.mounting;
  }
  std::size_t size() const override { return sequence_.frames().size(); }
  std::uint64_t stamp(std::size_t index) const override {
    return microseconds(has_times_ ? sequence_.frames().at(index).stamp
                                   : static_cast<double>(index) / kUsualRate);
  }
  void read(std::size_t index, std::uint16_t* depth) const override {
    const DepthImage image = sequence_.load(index);
    if (image.camera.width != camera_.width || image.camera.height != camera_.height)
      throw IoError(sequence_.frames().at(index).path.string(), "is of another size than the first image");
    toMillimetres(image, depth);
  }

private:
  DepthSequence sequence_;
  bool has_times_ = false;
};

/** Images of a simulated place, rendered when they are asked for. */
class SceneSource : public FrameSource {
public:
  explicit SceneSource(const SceneFile& file)
      : file_(file), simulated_camera_(centredKinect(file.width), file.noise, file.seed) {
    camera_ = simulated_camera_.camera();
    mounting_ = file.drive.mounting();
    rate_ = std::max(1, static_cast<int>(std::lround(file.pace.rate)));
    const bool is_map = file.run == "map";
    const auto frames = static_cast<std::size_t>(file.frames) + static_cast<std::size_t>(file.jump);
    try {
      SimulatedRun run = simulatedRun(file.scene, file.seed, is_map ? kMappingRun : kLaterRun, frames,
                                      file.drive, file.pace, RouteEnd::go_round);
      world_ = std::move(run.world);
      poses_ = std::move(run.poses);
    } catch (const std::exception& e) {
      throw IoError("scene " + file.scene, e.what());
    }
    const auto left_out = file.jump_at > 0 && file.jump_at < file.frames ? poses_.begin() + file.jump_at
                                                                         : poses_.end() - file.jump;
    poses_.erase(left_out, left_out + file.jump);
  }
  std::size_t size() const override { return poses_.size(); }
  std::uint64_t stamp(std::size_t index) const override {
    return microseconds(static_cast<double>(index) / file_.pace.rate);
  }
  void read(std::size_t index, std::uint16_t* depth) const override {
    toMillimetres(simulated_camera_.render(world_, poses_.at(index), index).depth, depth);
  }

private:
  SceneFile file_;
  SimulatedWorld world_;
  std::vector<Eigen::Isometry3d> poses_;
  SimulatedCamera simulated_camera_;
};

}  // namespace

SceneFile readSceneFile(const fs::path& path) { return Reader(path).read(); }

bool isFrameSource(const std::string& path) {
  return files::isFolder(path) || text::lowerExtension(path) == ".scene";
}

std::unique_ptr<FrameSource> openFrameSource(const std::string& path) {
  if (files::isFolder(path)) return std::make_unique<SequenceSource>(path);
  return std::make_unique<SceneSource>(readSceneFile(path));
}

}  // namespace facetloc
