// SPDX-License-Identifier: BSD-3-Clause
#include "base/pose_axes.h"
#include "base/text.h"
#include "bytes/files.h"
#include "recordings/image_list.h"
#include "recordings/name_numbers.h"
#include "recordings/pose_table.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <json/json.h>
#include <map>
#include <set>
#include <sstream>

namespace facetloc::internal {
namespace {

Json::Value jsonIn(const fs::path& file) try {
  std::istringstream in(files::readText(file));
  Json::Value value;
  std::string fault;
  if (!Json::parseFromStream(Json::CharReaderBuilder(), in, &value, &fault))
    throw IoError(file.string(), "is no JSON: " + std::string(text::trimmed(fault)));
  return value;
} catch (const Json::Exception& e) {
  throw IoError(file.string(), std::string("is no JSON: ") + e.what());
}

/** All numbers, in their order, of a matrix by rows or in one list. */
void addNumbers(const Json::Value& value, std::vector<double>& numbers) {
  if (value.isNumeric()) numbers.push_back(value.asDouble());
  if (value.isArray())
    for (const Json::Value& part : value) addNumbers(part, numbers);
}

/** Images are known by the numbers of their names, or without any, by the name. */
std::string keyOf(const fs::path& path) {
  const std::string name = path.stem().string(), numbers = numbersOf(name);
  return numbers.empty() ? name : numbers;
}

class FolderReader {
public:
  explicit FolderReader(const std::vector<ListedImage>& images) : images_(images) {
    for (const ListedImage& image : images) wanted_.insert(keyOf(image.path));
  }

  ScannedImages read(const fs::path& folder) {
    const auto isJson = [](const fs::directory_entry& entry) {
      return lowerExtension(entry.path()) == ".json" && files::isFile(entry);
    };
    const std::vector<fs::path> all = files::entriesOf(folder, isJson);
    for (const fs::path& file : all)
      if (entries_.empty() && text::lower(file.filename().string()).rfind("transforms", 0) == 0)
        addFrames(file);
    if (entries_.empty())
      for (const fs::path& file : all)
        if (wanted_.count(keyOf(file)) > 0 && !addFile(file)) break;
    return assigned();
  }

private:
  /** Calls work() and keeps its IoError. */
  template <typename Work>
  void guarded(const Work& work) try {
    work();
  } catch (const IoError& e) {
    if (found_.fault.empty()) found_.fault = e.what();
  }

  /** \param times keys of the time, the first of which counts */
  ListedImage entryOf(const Json::Value& object, std::initializer_list<const char*> times,
                      const fs::path& source) {
    ListedImage entry;
    if (!object.isObject()) return entry;
    for (const char* key : times)
      if (!entry.stamp && object[key].isNumeric() && std::isfinite(object[key].asDouble()))
        entry.stamp = object[key].asDouble();
    std::vector<double> numbers;
    for (const char* key : {"cameraPoseARFrame", "transform_matrix"})
      if (numbers.empty()) addNumbers(object[key], numbers);
    if (!numbers.empty()) guarded([&] { entry.T_w_c = poseOfNumbers(std::move(numbers), source); });
    if (entry.T_w_c) entry.T_w_c->linear() *= opticalInOpenGl();
    return entry;
  }

  void addFrames(const fs::path& file) {
    guarded([&] {
      const Json::Value json = jsonIn(file);
      if (!json.isObject() || !json["frames"].isArray()) return;
      for (const Json::Value& frame : json["frames"]) {
        if (!frame.isObject()) continue;
        const Json::Value& path = frame[frame.isMember("depth_file_path") ? "depth_file_path" : "file_path"];
        if (!path.isString()) continue;
        const std::string key = keyOf(path.asString());
        if (!entries_.emplace(key, entryOf(frame, {"timestamp"}, file)).second) {
          entries_.clear();
          throw IoError(file.string(), "is not used: two of its frames have the number " + key);
        }
      }
      if (!entries_.empty()) found_.file = file;
    });
  }

  /** False for the first file if it has neither a time nor a pose: it is of another kind. */
  bool addFile(const fs::path& file) {
    ListedImage entry;
    guarded([&] { entry = entryOf(jsonIn(file), {"timestamp", "time"}, file); });
    if (!entry.stamp && !entry.T_w_c) return !entries_.empty() || !found_.fault.empty();
    if (found_.file.empty()) found_.file = file;
    entries_.emplace(keyOf(file), entry);
    return true;
  }

  /** The images with an entry; of those with times, if most have one. */
  ScannedImages assigned() {
    std::size_t stamped = 0;
    for (const ListedImage& image : images_)
      if (const auto entry = entries_.find(keyOf(image.path)); entry != entries_.end()) {
        found_.images.push_back({image.path, entry->second.stamp, entry->second.T_w_c});
        stamped += entry->second.stamp.has_value();
      }
    if (2 * stamped > images_.size())
      found_.images.erase(std::remove_if(found_.images.begin(), found_.images.end(),
                                         [](const ListedImage& image) { return !image.stamp; }),
                          found_.images.end());
    if (2 * found_.images.size() <= images_.size()) found_.images.clear();
    found_.unknown = images_.size() - found_.images.size();
    return std::move(found_);
  }

  const std::vector<ListedImage>& images_;
  std::set<std::string> wanted_;
  std::map<std::string, ListedImage> entries_;
  ScannedImages found_;
};

}  // namespace

bool ScannedImages::stamped() const {
  std::set<double> stamps;
  for (const ListedImage& image : images)
    if (!image.stamp || !stamps.insert(*image.stamp).second) return false;
  return !images.empty();
}

bool ScannedImages::posed() const {
  return std::any_of(images.begin(), images.end(),
                     [](const ListedImage& image) { return image.T_w_c.has_value(); });
}

std::string ScannedImages::remark(bool with_times) const {
  const char* source = !with_times ? "poses" : posed() ? "times and poses" : "times";
  std::string words = fmt::format("the {} of the images are those of {}", source, file.filename().string());
  if (with_times && unknown > 0) addSentence(fmt::format("{} without a time there left out", unknown), words);
  addSentence(fault, words);
  return words;
}

ScannedImages scannedImages(const std::vector<ListedImage>& images, const std::vector<fs::path>& folders) {
  ScannedImages found;
  for (const fs::path& folder : folders) {
    found = FolderReader(images).read(folder);
    if (!found.images.empty() || !found.fault.empty()) break;
  }
  return found;
}

}  // namespace facetloc::internal
