// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/recording_layout.h"

#include "shared/text.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <ctime>
#include <map>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTrajectory = "groundtruth.txt";
constexpr const char* kLists[] = {"depth.txt", "associations.txt", "associated.txt"};
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

/** Names a frame by its stamp. */
void setStamp(FrameFile& frame, double stamp) {
  frame.stamp = stamp;
  frame.name = nameOfStamp(stamp);
}

/** The images of a folder, by the layouts from the most to the least peculiar. */
class LayoutFinder {
public:
  LayoutFinder(const std::vector<ListedImage>& images, const std::vector<fs::path>& beside)
      : images_(images), beside_(beside) {
    for (const ListedImage& image : images) layout_.frames.push_back({frameName(image.path), image.path, 0});
  }

  RecordingLayout find() {
    if (!layout_.frames.empty() &&
        !(isListed() || isSevenScenes() || isScanNet() || isIclNuim() || isStamped() || hasListBeside()))
      countFrames();
    std::stable_sort(layout_.frames.begin(), layout_.frames.end(),
                     [](const FrameFile& a, const FrameFile& b) { return a.stamp < b.stamp; });
    findPoses();
    return layout_;
  }

private:
  using Kind = RecordingLayout::Kind;

  void setKind(Kind kind) {
    layout_.kind = kind;
    layout_.stamped = true;
  }

  bool isListed() {
    if (!images_.front().stamp) return false;
    setKind(Kind::listed);
    for (std::size_t i = 0; i < images_.size(); ++i) setStamp(layout_.frames[i], *images_[i].stamp);
    return true;
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
    const fs::path poses = layout_.frames.front().path.parent_path() / ".." / "pose";
    if (!fs::is_directory(poses)) return false;
    return isNumbered(Kind::scannet, countIn,
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

  /** The first one by its name; empty if there is none. */
  fs::path iclTrajectory() const {
    for (const fs::path& folder : beside_) {
      std::vector<fs::path> found;
      std::error_code ignored;
      for (const auto& entry : fs::directory_iterator(folder, ignored))
        if (endsWith(entry.path().filename().string(), kIclEnding)) found.push_back(entry.path());
      if (!found.empty()) return *std::min_element(found.begin(), found.end());
    }
    return {};
  }

  /** One stray name among stamps is an error: it would silently turn all stamps into indices. */
  bool isStamped() {
    const auto has_stamp = [](const FrameFile& frame) { return stampInName(frame.name).has_value(); };
    std::vector<FrameFile>& frames = layout_.frames;
    const auto stray = std::find_if_not(frames.begin(), frames.end(), has_stamp);
    if (stray != frames.end()) {
      if (std::any_of(frames.begin(), frames.end(), has_stamp))
        throw IoError(stray->path.string(),
                      "its name is no time stamp, unlike those of other images beside it");
      return false;
    }
    for (FrameFile& frame : frames) {
      frame.stamp = *stampInName(frame.name);
      if (!text::to<double>(frame.name)) frame.name = nameOfStamp(frame.stamp);
    }
    layout_.stamped = true;
    return true;
  }

  /** Takes the images that the list has: others have no times. */
  bool hasListBeside() {
    for (const char* name : kLists) {
      const auto list = findIn(beside_, name);
      if (!list) continue;
      const LayoutFinder listed(imagesOfList(*list), beside_);
      if (listed.images_.empty() || !listed.images_.front().stamp) continue;
      *this = listed;
      return isListed();
    }
    return false;
  }

  void countFrames() {
    for (std::size_t i = 0; i < layout_.frames.size(); ++i) layout_.frames[i].stamp = static_cast<double>(i);
  }

  /** Indices are no times: poses would be matched to them at random. */
  void findPoses() {
    if (!layout_.stamped && !layout_.frames.empty()) return;
    if (const auto file = findIn(beside_, kTrajectory)) layout_.poses = {*file, 1, {}};
  }

  std::vector<ListedImage> images_;
  std::vector<fs::path> beside_;
  RecordingLayout layout_;
};

/** Seconds since 1970 of 20121214T142255.814212, as if its clock had shown universal time. */
std::optional<double> secondsOfIsoTime(const std::string& s) {
  constexpr std::size_t kLength = 15;  // of the whole seconds
  if (s.size() < kLength || s[8] != 'T' || (s.size() > kLength && s[kLength] != '.')) return {};
  for (std::size_t i = 0; i < s.size(); ++i)
    if (i != 8 && i != kLength && !std::isdigit(static_cast<unsigned char>(s[i]))) return {};
  const auto number = [&s](std::size_t begin, std::size_t size) {
    return text::to<int>(s.substr(begin, size));
  };
  const auto year = number(0, 4), month = number(4, 2), day = number(6, 2), hour = number(9, 2),
             minute = number(11, 2), second = number(13, 2);
  const auto fraction = text::to<double>("0" + s.substr(kLength) + "0");
  if (!year || !month || !day || !hour || !minute || !second || !fraction) return {};
  if (*month < 1 || *month > 12 || *day < 1 || *day > 31 || *hour > 23 || *minute > 59 || *second > 60)
    return {};
  std::tm time{};
  time.tm_year = *year - 1900, time.tm_mon = *month - 1, time.tm_mday = *day;
  time.tm_hour = *hour, time.tm_min = *minute, time.tm_sec = *second;
  return static_cast<double>(timegm(&time)) + *fraction;
}

}  // namespace

std::string RecordingLayout::inWords() const {
  switch (kind) {
  case Kind::listed:
    return "images with their times in a list";
  case Kind::seven_scenes:
    return "the layout of 7-Scenes and 3DMatch";
  case Kind::scannet:
    return "the layout of ScanNet";
  case Kind::icl_nuim:
    return "the layout of ICL-NUIM";
  case Kind::plain:
    break;
  }
  return stamped ? "images named by their times" : "images in the order of their names, without times";
}

std::optional<double> stampInName(const std::string& name) {
  const auto number = text::to<double>(name);
  if (number) return std::isfinite(*number) ? number : std::nullopt;
  return secondsOfIsoTime(name.substr(name.find_last_of('_') + 1));  // frame_20121214T142255.814212
}

std::string nameOfStamp(double stamp) { return text::decimals(stamp, kStampDigits); }

RecordingLayout layoutOf(const std::vector<ListedImage>& images, const std::vector<fs::path>& beside) {
  return LayoutFinder(images, beside).find();
}

}  // namespace facetloc::internal
