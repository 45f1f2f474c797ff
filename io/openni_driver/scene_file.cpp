// SPDX-License-Identifier: BSD-3-Clause
#include "scene_file.h"

#include "base/text.h"
#include "bytes/files.h"

#include <facetloc/io/error.h>

#include <fmt/format.h>
#include <set>
#include <type_traits>
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

class Reader {
public:
  explicit Reader(const std::filesystem::path& path) : path_(path.string()) {}

  SceneFile read() {
    const std::string content = files::readText(path_);
    for (const std::string_view line : text::lines(content)) {
      ++line_;
      const auto entry = text::trimmed(text::withoutComment(line));
      if (!entry.empty()) store(entry);
    }
    if (file_.scene.empty()) throw IoError(path_, "has no scene");
    checkRanges(file_.drive), checkRanges(file_.pace), checkRanges(file_.noise);
    return file_;
  }

private:
  [[noreturn]] void fail(const std::string& cause) const {
    throw IoError(path_, fmt::format("line {}: {}", line_, cause));
  }

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
  int line_ = 0;
  std::set<std::string> seen_;
  SceneFile file_;
};

}  // namespace

SceneFile readSceneFile(const std::filesystem::path& path) { return Reader(path).read(); }

}  // namespace facetloc
