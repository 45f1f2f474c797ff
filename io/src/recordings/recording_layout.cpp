// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/recording_layout.h"

#include "base/text.h"
#include "recordings/name_numbers.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <numeric>
#include <regex>

namespace facetloc::internal {
namespace {

constexpr const char* kTrajectory = "groundtruth.txt";
constexpr const char* kLists[] = {"depth.txt",       "associations.txt", "associated.txt",
                                  "association.txt", "associate.txt",    "depth.csv"};
constexpr const char* kIclEnding = ".gt.freiburg";
constexpr int kStampDigits = 6;  // microseconds

std::optional<int> countIn(const std::string& digits) {
  const auto count = text::to<int>(digits);
  return count && *count >= 0 ? count : std::nullopt;
}

/** 123 of frame-000123. */
std::optional<int> countAtEndOf(const std::string& name) {
  const auto last = name.find_last_not_of("0123456789");
  return countIn(last == std::string::npos ? name : name.substr(last + 1));
}

std::string nameOfStamp(double stamp) { return text::decimals(stamp, kStampDigits); }

/** Names a frame by its stamp. */
void setStamp(FrameFile& frame, double stamp) {
  frame.stamp = stamp;
  frame.name = nameOfStamp(stamp);
}

constexpr int kNoPoses = 9;

/** The less, the likelier are they the poses of the images. */
int rankOf(const fs::path& file) {
  const std::string extension = lowerExtension(file);
  if (extension != ".txt" && extension != ".csv" && extension != ".log" && extension != ".tum")
    return kNoPoses;
  const std::string name = text::lower(file.stem().string());
  const auto has = [&name](const char* word) { return name.find(word) != std::string::npos; };
  if (has("groundtruth") || has("ground_truth") || name == "gt" || endsWith(name, "_gt")) return 0;
  if (has("robot") || has("keyframe")) return kNoPoses;
  if (has("camera_pose") || has("cameratrajectory") || has("camera_trajectory")) return 1;
  if (has("pose")) return 2;
  if (has("traj")) return 3;
  return name == "odometry" && extension == ".csv" ? 4 : kNoPoses;
}

bool hasPoses(const fs::path& file) {
  try {
    return !readPoseTable(file).rows.empty();
  } catch (const IoError&) {
    return false;
  }
}

/** The file of a recording's folders that has poses by its name, and can be read as such: first
 * those of a ground truth, then poses of a camera, then other poses, then trajectories, then the odometry.csv
 * of phones. */
std::optional<fs::path> trajectoryIn(const std::vector<fs::path>& folders) {
  for (const fs::path& folder : folders) {
    std::vector<std::pair<int, fs::path>> found;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored))
      if (const int rank = rankOf(entry.path()); rank < kNoPoses && entry.is_regular_file(ignored))
        found.emplace_back(rank, entry.path());
    std::sort(found.begin(), found.end());
    for (const auto& [rank, file] : found)
      if (hasPoses(file)) return file;
  }
  return {};
}

/** The images of a folder, by the layouts from the most to the least peculiar. */
class LayoutFinder {
public:
  LayoutFinder(const std::vector<ListedImage>& images, const std::vector<fs::path>& beside,
               const std::vector<fs::path>& within)
      : images_(images), beside_(beside), within_(within) {
    for (const ListedImage& image : images) layout_.frames.push_back({frameName(image.path), image.path, 0});
  }

  RecordingLayout find() {
    if (!images_.empty() && !images_.front().stamp) requireOneSeries();
    if (!layout_.frames.empty() &&
        !(isListed() || isSevenScenes() || isScanNet() || isIclNuim() || hasNumbers()) && !hasTimesBeside())
      for (std::size_t i = 0; i < layout_.frames.size(); ++i)
        layout_.frames[i].stamp = static_cast<double>(i);
    if (layout_.unit.counted && layout_.kind == Kind::plain) try {
        hasTimesBeside();
      } catch (const IoError&) {  // the numbers are enough
      }
    sort();
    findPoses();
    return layout_;
  }

private:
  using Kind = RecordingLayout::Kind;

  /** Images of several cameras are no drive. */
  void requireOneSeries() const {
    std::vector<std::string> names;
    for (const FrameFile& frame : layout_.frames) names.push_back(frame.name);
    const std::vector<std::size_t> series = seriesInNames(names);
    const std::size_t n = *std::max_element(series.begin(), series.end()) + 1;
    if (n == 1) return;
    std::string examples;
    for (std::size_t i = 0; i < n; ++i) {
      const auto first = std::find(series.begin(), series.end(), i) - series.begin();
      examples +=
          (i > 0 ? ", " : "") + layout_.frames[static_cast<std::size_t>(first)].path.filename().string();
    }
    throw IoError(
        layout_.frames.front().path.parent_path().string(),
        fmt::format("has images of {} cameras, or {} series, that begin with {}; move those of one into a "
                    "folder, or name them in a list",
                    n, n, examples));
  }

  void findPosesByName() {
    if (!layout_.frames.empty()) findPosesBesideImages();
    if (layout_.poses.empty()) takeScannedPoses();
    if (!layout_.poses.empty()) return;
    if (const auto file = trajectoryIn(within_)) {
      layout_.poses = {*file, 0, {}, {}};
      say(fmt::format("the poses are those of {}", file->string()));
    }
  }

  /** Files with the numbers of images in their names that have a pose each: 17_pose.txt of 17_depth.png. */
  void findPosesBesideImages() {
    static const std::regex digits("[0-9]+");
    std::map<std::string, std::map<std::string, fs::path>> kinds;  // keyed by words, then numbers
    const fs::path folder = layout_.frames.front().path.parent_path();
    for (const fs::path& file : files::entriesOf(folder, files::isFile)) {
      const std::string name = file.stem().string(), numbers = numbersOf(name);
      if (lowerExtension(file) == ".txt" && !numbers.empty())
        kinds[std::regex_replace(name, digits, "#")].emplace(numbers, file);
    }
    for (const auto& [words, files] : kinds) {
      std::vector<PoseFile> poses;
      for (const FrameFile& frame : layout_.frames)
        if (const auto file = files.find(numbersOf(frame.path.stem().string())); file != files.end())
          poses.push_back({frame.stamp, file->second});
      if (2 * poses.size() <= layout_.frames.size()) continue;
      try {
        readPoseOfImage(poses.front().path);
      } catch (const IoError&) {
        continue;
      }
      say(fmt::format("the poses are those of {} and so on", poses.front().path.filename().string()));
      layout_.poses.of_images = std::move(poses);
      return;
    }
  }

  void setKind(Kind kind) {
    layout_.kind = kind;
    layout_.stamped = true;
  }

  bool isListed() {
    if (!images_.front().stamp) return false;
    setKind(Kind::listed);
    std::vector<std::string> names;
    NameNumbers stamps;
    stamps.decimal = true;
    for (const ListedImage& image : images_) {
      names.push_back(frameName(image.path));
      stamps.numbers.push_back(*image.stamp);
    }
    const auto in_names = numbersInNames(names);
    if (in_names && in_names->numbers == stamps.numbers) stamps = *in_names;
    takeNumbers(stamps);
    for (FrameFile& frame : layout_.frames) frame.name = nameOfStamp(frame.stamp);
    for (std::size_t i = 0; i < images_.size(); ++i)
      if (images_[i].T_w_c) layout_.poses.listed.push_back({layout_.frames[i].stamp, *images_[i].T_w_c});
    return true;
  }

  /** Takes the numbers of the frames, in their order. */
  void takeNumbers(const NameNumbers& found) {
    layout_.numbers = found.numbers;
    layout_.unit = unitOfNumbers(found.numbers, found.decimal, found.padded);
    for (std::size_t i = 0; i < found.numbers.size(); ++i) {
      FrameFile& frame = layout_.frames[i];
      const double seconds = found.numbers[i] * layout_.unit.seconds;
      const bool is_name = layout_.unit.seconds == 1 && text::to<double>(frame.name);
      if (is_name)
        frame.stamp = seconds;
      else
        setStamp(frame, seconds);
    }
    if (layout_.unit.seconds != 1 && !layout_.unit.counted)
      layout_.remark = fmt::format("the stamps of the images are taken to be {}", layout_.unit.toString());
  }

  /** Numbers all frames, and finds the file that may have the pose of each. */
  template <typename Count, typename PoseOf>
  bool isNumbered(Kind kind, Count countOf, PoseOf poseOf) {
    std::vector<FrameFile> frames = layout_.frames;
    std::vector<PoseFile> poses;
    for (FrameFile& frame : frames) {
      const std::optional<int> count = countOf(frame.name);
      if (!count) return false;
      const fs::path pose = poseOf(frame);
      setStamp(frame, *count / kFrameRate);
      if (!pose.empty() && fs::exists(pose)) poses.push_back({frame.stamp, pose});
    }
    setKind(kind);
    layout_.frames = std::move(frames);
    layout_.poses.of_images = std::move(poses);
    return true;
  }

  bool isSevenScenes() {
    const std::string ending = ".depth";
    const auto withoutEnding = [&ending](const std::string& name) {
      return name.substr(0, name.size() - ending.size());
    };
    if (!endsWith(layout_.frames.front().name, ending)) return false;
    return isNumbered(
        Kind::seven_scenes,
        [&](const std::string& name) {
          return endsWith(name, ending) ? countAtEndOf(withoutEnding(name)) : std::nullopt;
        },
        [&](const FrameFile& frame) {
          return frame.path.parent_path() / (withoutEnding(frame.name) + ".pose.txt");
        });
  }

  bool isScanNet() {
    const fs::path beside = layout_.frames.front().path.parent_path() / "..";
    const fs::path poses = beside / (fs::is_directory(beside / "pose") ? "pose" : "poses");
    if (!fs::is_directory(poses)) return false;
    const auto count = [](const std::string& name) {
      return name.find('.') == std::string::npos ? countAtEndOf(name) : std::nullopt;  // 1.5 is a time
    };
    return isNumbered(Kind::scannet, count,
                      [&](const FrameFile& frame) { return poses / (frame.name + ".txt"); });
  }

  bool isIclNuim() {
    const fs::path trajectory = iclTrajectory();
    if (trajectory.empty() ||
        !isNumbered(Kind::icl_nuim, countIn, [](const FrameFile&) { return fs::path(); }))
      return false;
    layout_.poses.trajectory = trajectory;
    layout_.poses.seconds = 1 / kFrameRate;
    return true;
  }

  /** The first one by its name; empty without one. */
  fs::path iclTrajectory() const {
    for (const fs::path& folder : beside_) {
      const auto found = files::entriesOf(
          folder, [](const auto& entry) { return endsWith(entry.path().filename().string(), kIclEnding); });
      if (!found.empty()) return found.front();
    }
    return {};
  }

  /** One stray name among stamps is an error: it would silently turn all stamps into indices. */
  bool hasNumbers() {
    const auto has_stamp = [](const FrameFile& frame) { return stampInName(frame.name).has_value(); };
    const std::vector<FrameFile>& frames = layout_.frames;
    const auto stray = std::find_if_not(frames.begin(), frames.end(), has_stamp);
    if (stray != frames.end() && std::any_of(frames.begin(), frames.end(), has_stamp))
      throw IoError(stray->path.string(),
                    "its name is no time stamp, unlike those of other images beside it");
    std::vector<std::string> names;
    for (const FrameFile& frame : frames) names.push_back(frame.name);
    const auto numbers = numbersInNames(names);
    if (!numbers) return false;
    takeNumbers(*numbers);
    layout_.stamped = true;
    return true;
  }

  /** Takes the images that the list has: others have no times. */
  bool hasListBeside() {
    for (const char* name : kLists) {
      const auto list = findIn(beside_, name);
      if (!list) continue;
      LayoutFinder listed(imagesOfList(*list), beside_, within_);
      if (listed.images_.empty() || !listed.isListed() || listed.layout_.unit.counted) continue;
      *this = listed;
      return true;
    }
    return false;
  }

  bool hasTimesBeside() { return hasListBeside() || hasScannedTimes(); }

  const ScannedImages& scanned() {
    if (scanned_) return *scanned_;
    scanned_ = scannedImages(images_, within_);
    if (scanned_->images.empty()) say(scanned_->fault);
    return *scanned_;
  }

  /** Takes the images that have a time in JSON. */
  bool hasScannedTimes() {
    if (!scanned().stamped()) return false;
    LayoutFinder listed(scanned().images, beside_, within_);
    if (!listed.isListed() || listed.layout_.unit.counted) return false;
    listed.scanned_ = scanned();
    listed.say(scanned().remark(true));
    *this = LayoutFinder(listed);
    return true;
  }

  /** Takes the poses of JSON without times. */
  void takeScannedPoses() {
    if (!scanned().posed()) return;
    std::map<fs::path, double> stamps;
    for (const FrameFile& frame : layout_.frames) stamps.emplace(frame.path, frame.stamp);
    for (const ListedImage& image : scanned().images)
      if (image.T_w_c) layout_.poses.listed.push_back({stamps.at(image.path), *image.T_w_c});
    say(scanned().remark(false));
  }

  /** Sorts the frames by their stamps, and each number with its frame. */
  void sort() {
    std::vector<std::size_t> order(layout_.frames.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const std::vector<FrameFile> frames = layout_.frames;
    const std::vector<double> numbers = layout_.numbers;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return frames[a].stamp < frames[b].stamp; });
    for (std::size_t i = 0; i < order.size(); ++i) {
      layout_.frames[i] = frames[order[i]];
      if (!numbers.empty()) layout_.numbers[i] = numbers[order[i]];
    }
  }

  /** Indices are no times: poses would be matched to them at random. */
  void findPoses() {
    if (!layout_.stamped && !layout_.frames.empty()) return;
    if (const auto file = findIn(beside_, kTrajectory))
      layout_.poses = {*file, 0, {}, {}};
    else if (layout_.poses.empty())
      findPosesByName();
    if (layout_.unit.counted && layout_.kind != Kind::icl_nuim) takeTimesOfPoses();
  }

  /** Gives images that are only counted the times of the poses, if there is one for each. */
  void takeTimesOfPoses() {
    const fs::path& file = layout_.poses.trajectory;
    PoseTable table;
    if (!file.empty()) try {
        table = readPoseTable(file);
      } catch (const IoError&) {  // told to who asks for the poses
      }
    const bool same_numbers = haveSameNumbers(table, layout_.times());
    const bool as_many = table.stamped && table.rows.size() == layout_.frames.size();
    if (same_numbers || (as_many && !table.rows.empty())) {
      for (std::size_t i = 0; i < layout_.frames.size(); ++i) {
        const double stamp = same_numbers ? layout_.numbers[i] : table.rows[i].stamp * table.unit.seconds;
        setStamp(layout_.frames[i], stamp);
      }
      if (same_numbers) layout_.unit = {};
      return;
    }
    layout_.assumed = true;
    say(fmt::format("the images are only numbered: they are taken to be 1/{} s apart", kFrameRate));
  }

  void say(const std::string& words) { addSentence(words, layout_.remark); }

  std::vector<ListedImage> images_;
  std::vector<fs::path> beside_, within_;
  RecordingLayout layout_;
  std::optional<ScannedImages> scanned_;  // once they were looked for
};

}  // namespace

std::string RecordingLayout::toString() const {
  constexpr const char* kKinds[] = {"", "images with their times in a list",
                                    "the layout of 7-Scenes and 3DMatch", "the layout of ScanNet",
                                    "the layout of ICL-NUIM"};
  if (kind != Kind::plain) return kKinds[static_cast<std::size_t>(kind)];
  return stamped ? "images named by their times" : "images in the order of their names, without times";
}

ImageTimes RecordingLayout::times() const {
  ImageTimes times{{}, numbers, unit};
  for (const FrameFile& frame : frames) times.stamps.push_back(frame.stamp);
  return times;
}

RecordingLayout layoutOf(const std::vector<ListedImage>& images, const std::vector<fs::path>& beside,
                         const std::vector<fs::path>& within) {
  return LayoutFinder(images, beside, within).find();
}

}  // namespace facetloc::internal
