// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/image_list.h"

#include "base/text.h"
#include "images/depth_file.h"
#include "recordings/name_numbers.h"
#include "recordings/pose_table.h"

#include <facetloc/io/error.h>
#include <facetloc/io/png.h>
#include <facetloc/io/segment_file.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr const char* kDepth = "depth";  // part of the name of an image or of its folder
constexpr const char* kOthers[] = {"conf", "confidence", "color",   "colour", "rgb",  "mask", "label",
                                   "seg",  "normal",     "normals", "ir",     "gray", "grey", "amplitude"};

/** frame-000000.depth.png, depth_00001.png, 000001-depth.png. */
bool isNamedDepth(const fs::path& path) { return hasWord(path.stem().string(), kDepth); }

/** conf_00000.png. */
bool isNamedOtherwise(const fs::path& path) {
  const std::string name = path.stem().string();
  return std::any_of(std::begin(kOthers), std::end(kOthers),
                     [&name](const char* word) { return hasWord(name, word); });
}

bool mentionsDepth(const fs::path& folder) {
  return text::lower(folder.filename().string()).find(kDepth) != std::string::npos;
}

bool isInDepthFolder(std::string_view path) {
  const fs::path folder = fs::path(path).parent_path();
  return std::any_of(folder.begin(), folder.end(), mentionsDepth);
}

bool isHidden(const fs::path& path) { return path.filename().string().front() == '.'; }

/** Pictures of depth in 8 bits or in colours are no depth images. */
bool isDepthImage(const fs::path& path) {
  constexpr int kBits = 16;
  if (!isPng(path)) return true;
  const auto size = pngSize(path);
  return size && size->bits == kBits;
}

std::vector<fs::path> foldersIn(const fs::path& folder) {
  return files::entriesOf(folder, [](const auto& e) { return files::isFolder(e) && !isHidden(e.path()); });
}

/** Depth images in a folder that says so, or else depth images that say so themselves. */
bool hasDepthImages(const fs::path& folder, bool by_folder) {
  if (by_folder && !mentionsDepth(folder)) return false;
  const auto images = imagesOfFolder(folder);
  return !images.empty() && (by_folder || isNamedDepth(images.front().path)) &&
         isDepthImage(images.front().path);
}

/** A line of a list: numbers, and the paths that they are before. */
struct ListLine {
  struct Path {
    std::string text;
    std::vector<double> before;  // numbers, since the path before
  };
  std::vector<Path> paths;
  std::vector<double> after;  // the last path
};

ListLine splitLine(std::string_view entry) {
  ListLine line;
  for (const std::string_view word : text::words(entry)) {
    if (const auto number = text::to<double>(word))
      line.after.push_back(*number);
    else
      line.paths.push_back({std::string(word), std::exchange(line.after, {})});
  }
  return line;
}

class ListParser {
public:
  explicit ListParser(const fs::path& list) : list_(list) {}

  std::vector<ListedImage> parse(std::string_view content) {
    files::forEachLine(content, list_.string(), [this](std::string_view line) {
      const auto entry = text::trimmed(line);
      if (!entry.empty() && entry.front() != '#') add(entry);
    });
    return images_;
  }

private:
  [[noreturn]] static void fail(const std::string& cause) { throw std::invalid_argument(cause); }

  void add(std::string_view entry) {
    ListLine line = splitLine(entry);
    if (line.paths.size() == 1 && line.paths[0].text.find(',') != std::string::npos) {
      std::string spaced(entry);  // stamp,path
      std::replace(spaced.begin(), spaced.end(), ',', ' ');
      if (ListLine parts = splitLine(spaced); !parts.paths.empty() && !parts.paths[0].before.empty())
        line = std::move(parts);
    }
    const bool has_stamps = std::any_of(line.paths.begin(), line.paths.end(),
                                        [](const ListLine::Path& path) { return !path.before.empty(); });
    if (images_.empty() && !has_stamps && !isImage(fs::path(entry)) && isHeader(line)) return;
    if (!has_stamps && !areFiles(line)) return put(std::string(entry), {}, {});  // a path with blanks in it
    const ListLine::Path& depth = depthOf(line.paths);
    std::optional<double> stamp;
    if (!depth.before.empty()) stamp = depth.before.back();
    put(depth.text, stamp, poseOf(line));
  }

  /** One image and perhaps its pose, or several names with endings. */
  static bool areFiles(const ListLine& line) {
    constexpr std::size_t kPose = 7;
    if (line.paths.size() == 1)
      return isImage(line.paths[0].text) && (line.after.empty() || line.after.size() == kPose);
    return !line.paths.empty() && line.after.empty() &&
           std::all_of(line.paths.begin(), line.paths.end(),
                       [](const ListLine::Path& path) { return fs::path(path.text).has_extension(); });
  }

  /** A line of names above the columns. */
  static bool isHeader(const ListLine& line) {
    return line.after.empty() &&
           std::any_of(line.paths.begin(), line.paths.end(), [](const ListLine::Path& p) {
             return text::lower(p.text).find("stamp") != std::string::npos || text::lower(p.text) == "time";
           });
  }

  /** The depth image among several: the one whose folder or name says depth. */
  static const ListLine::Path& depthOf(const std::vector<ListLine::Path>& paths) {
    if (paths.size() == 1) return paths[0];
    const auto only = [&paths](auto holds) -> const ListLine::Path* {
      const auto found = std::find_if(paths.begin(), paths.end(), holds);
      return found != paths.end() && std::find_if(found + 1, paths.end(), holds) == paths.end() ? &*found
                                                                                                : nullptr;
    };
    if (const auto* path = only([](const ListLine::Path& p) { return isInDepthFolder(asPath(p.text)); }))
      return *path;
    if (const auto* path = only([](const ListLine::Path& p) { return isNamedDepth(asPath(p.text)); }))
      return *path;
    if (const auto* path = only([](const ListLine::Path& p) { return isImage(p.text); })) return *path;
    fail(fmt::format("names {} images, of which one has to be in a folder called depth",
                     paths.size() == 2 ? "two" : std::to_string(paths.size())));
  }

  /** Pose in front of the first path and its stamp, or behind the last path. */
  static std::optional<Eigen::Isometry3d> poseOf(const ListLine& line) {
    constexpr std::size_t kPose = 7;
    std::vector<double> numbers = line.paths.front().before;
    if (!numbers.empty()) numbers.pop_back();
    if (numbers.empty()) numbers = line.after;
    if (numbers.size() != kPose && numbers.size() != kPose + 1) return {};
    std::array<double, kPose> columns{};
    std::copy(numbers.end() - kPose, numbers.end(), columns.begin());
    return poseOfColumns(columns);
  }

  static std::string asPath(std::string text) {
    std::replace(text.begin(), text.end(), '\\', '/');
    return text;
  }

  /** Path of an entry, whose backslashes stand for slashes unless a file has such a name. */
  fs::path pathOf(const std::string& entry) const {
    const fs::path path = list_.parent_path() / fs::path(entry);  // an absolute entry stays as it is
    if (entry.find('\\') == std::string::npos || files::isThere(path)) return path;
    return list_.parent_path() / fs::path(asPath(entry));
  }

  /** An image that several others are the nearest of is listed with each of them. */
  void put(const std::string& entry, std::optional<double> stamp,
           const std::optional<Eigen::Isometry3d>& pose) {
    const fs::path path = pathOf(entry);
    if (!isImage(path)) fail(fmt::format("'{}' is not a depth image ({})", entry, imageEndings()));
    if (!images_.empty() && images_.front().stamp.has_value() != stamp.has_value())
      fail(fmt::format("has {} time stamp, unlike the lines before it", stamp ? "a" : "no"));
    if (!listed_.insert(path.lexically_normal()).second) return;
    images_.push_back({path, stamp, pose});  // one that is missing fails when it is read, and stops no other
  }

  fs::path list_;
  std::vector<ListedImage> images_;
  std::set<fs::path> listed_;
};

/** A kind of file that is not read, and how to make one that is. */
struct Unread {
  const char* extension;
  const char* advice;
};

constexpr Unread kUnread[] = {
    {".exr", "OpenEXR is not read; as TIFF it is: oiiotool IN.exr --ch Y -d float -o OUT.tif"},
    {".hdf5",
     "HDF5 is not read; as NPY it is: python3 -c \"import h5py, numpy, sys; "
     "numpy.save(sys.argv[2], numpy.array(h5py.File(sys.argv[1])['dataset'], 'f4'))\" IN.hdf5 OUT.npy"},
    {".h5", "HDF5 is not read; as NPY it is (h5py and numpy.save)"},
    {".npz", "a .npz holds several arrays; write depth alone: numpy.save('OUT.npy', "
             "numpy.load('IN.npz')['depth'])"},
    {".db", "a database of RTAB-Map is read if it is named itself, not its folder"},
    {".oni", "an .oni recording is read if it is named itself, not its folder"},
    {".mkv", "recordings of Azure Kinects are not read; Open3D's azure_kinect_mkv_reader writes depth PNGs"},
    {".sens", "ScanNet's .sens is not read; its SensReader exports depth, pose and intrinsic folders"},
    {".klg", "Kintinuous' .klg is not read; write its depth images as PNGs"},
    {".r3d", "Record3D's .r3d is not read; its export as EXR + RGB, with the depth converted to TIFF, is"},
    {".depth", "Record3D's compressed .depth is not read; its export as EXR + RGB, converted to TIFF, is"},
    {".bin", "raw depth has no size in it; write it as NPY: numpy.save('OUT.npy', numpy.fromfile('IN.bin', "
             "'u2').reshape(HEIGHT, WIDTH))"},
    {".raw", "raw depth has no size in it; write it as NPY: numpy.save('OUT.npy', numpy.fromfile('IN.raw', "
             "'u2').reshape(HEIGHT, WIDTH))"},
    {".jpg", "JPEG holds no depth: it has 8 bits, and is not exact"},
    {".jpeg", "JPEG holds no depth: it has 8 bits, and is not exact"},
    {".ply", "PLY clouds are not organized; as organized PCD they are read"},
    {".mp4", "videos hold no depth"},
    {".zstd", "unpack it first: zstd -d"},
    {".zst", "unpack it first: zstd -d"},
    {".zip", "unpack it first"},
};

/** "120 .jpg, 3 .txt". */
std::string kindsIn(const fs::path& folder) {
  constexpr std::size_t kMostKinds = 6;
  std::map<std::string, std::size_t> kinds;
  for (const fs::path& file : files::entriesOf(folder, files::isFile)) ++kinds[lowerExtension(file)];
  std::string words;
  std::size_t n = 0;
  for (const auto& [extension, count] : kinds) {
    if (++n > kMostKinds) return words + ", ...";
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", count,
                         extension.empty() ? "without an ending" : extension);
  }
  return words;
}

std::string adviceIn(const fs::path& folder) {
  std::error_code ignored;
  std::map<std::string, std::string> found;  // keyed by advice, so that the first by name counts
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (const std::string advice = adviceOnFile(entry.path()); !advice.empty())
      found.emplace(lowerExtension(entry.path()), advice);
  for (const Unread& kind : kUnread)
    if (const auto advice = found.find(kind.extension); advice != found.end()) return advice->second;
  return {};
}

}  // namespace

std::string frameName(const fs::path& path) {
  const std::string name = path.filename().string();
  if (isSegmentFile(path)) return name.substr(0, name.size() - std::string(kSegmentEnding).size());
  return path.stem().string();
}

bool isCloud(const fs::path& path) { return lowerExtension(path) == ".pcd"; }
bool isImage(const fs::path& path) { return isDepthFile(path) || isCloud(path); }
bool isImageList(const fs::path& path) {
  const std::string extension = lowerExtension(path);
  return extension == ".txt" || extension == ".lst" || extension == ".csv";
}

std::string imageEndings() { return ".pcd, " + depthFileEndings(); }

std::vector<ListedImage> imagesOfFolder(const fs::path& folder) {
  std::vector<ListedImage> images;
  try {
    for (const auto& entry : fs::directory_iterator(folder)) {
      // A link that leads nowhere is an image that cannot be read.
      if (!isHidden(entry.path()) && isImage(entry.path()) && !entry.is_directory())
        images.push_back({entry.path()});
    }
  } catch (const fs::filesystem_error& e) {
    throw IoError(folder.string(), e.what());
  }
  const auto keepIfAny = [&images](auto counts) {
    if (std::any_of(images.begin(), images.end(), counts))
      images.erase(std::remove_if(images.begin(), images.end(), std::not_fn(counts)), images.end());
  };
  keepIfAny([](const ListedImage& image) { return isSegmentFile(image.path); });
  keepIfAny([](const ListedImage& image) { return isNamedDepth(image.path); });
  keepIfAny([](const ListedImage& image) { return !isNamedOtherwise(image.path); });
  std::sort(images.begin(), images.end(),
            [](const ListedImage& a, const ListedImage& b) { return a.path < b.path; });
  return images;
}

fs::path folderOfImages(const fs::path& recording) {
  if (files::isFolder(recording / kDepth)) return recording / kDepth;
  const auto own = imagesOfFolder(recording);
  if (std::any_of(own.begin(), own.end(), [](const ListedImage& image) { return isDepthImage(image.path); }))
    return recording;
  std::vector<fs::path> folders = foldersIn(recording);
  for (int level = 0; level < 2 && !folders.empty(); ++level) {
    for (const bool by_folder : {true, false}) {
      std::vector<fs::path> found;
      std::copy_if(folders.begin(), folders.end(), std::back_inserter(found),
                   [&](const fs::path& folder) { return hasDepthImages(folder, by_folder); });
      if (found.size() == 1) return found[0];
      if (found.empty()) continue;
      std::string names;
      for (const fs::path& folder : found) names += (names.empty() ? "" : ", ") + folder.string();
      throw IoError(recording.string(),
                    fmt::format("has {} folders of depth images: {}; name one of them", found.size(), names));
    }
    std::vector<fs::path> below;
    for (const fs::path& folder : folders)
      for (fs::path& path : foldersIn(folder)) below.push_back(std::move(path));
    folders = std::move(below);
  }
  return recording;
}

std::vector<ListedImage> imagesOfList(const fs::path& list) {
  return ListParser(list).parse(files::readText(list));
}

std::vector<fs::path> placesBeside(const fs::path& images, const fs::path& asked) {
  std::vector<fs::path> places;
  for (const fs::path& folder : {images, images / "..", asked, asked / ".."})
    for (const fs::path& place : {folder.lexically_normal(), folder})
      if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
  return places;
}

std::optional<fs::path> findIn(const std::vector<fs::path>& folders, const fs::path& name) {
  for (const fs::path& folder : folders)
    if (fs::is_regular_file(folder / name)) return folder / name;
  return {};
}

std::string adviceOnFile(const fs::path& path) {
  const std::string extension = lowerExtension(path);
  for (const Unread& kind : kUnread)
    if (extension == kind.extension) return kind.advice;
  return {};
}

std::string foundIn(const fs::path& folder) {
  constexpr std::size_t kMostFolders = 8;
  std::string words = kindsIn(folder), advice = adviceIn(folder);
  const std::vector<fs::path> folders = files::entriesOf(folder, files::isFolder);
  for (std::size_t i = 0; i < folders.size() && i < kMostFolders; ++i) {
    const std::string kinds = kindsIn(folders[i]);
    words += fmt::format("{}{}/ ({})", words.empty() ? "" : ", ", folders[i].filename().string(),
                         kinds.empty() ? "no files" : kinds);
    if (advice.empty()) advice = adviceIn(folders[i]);
  }
  if (words.empty()) return "it is empty";
  return "found: " + words + (advice.empty() ? "" : "; " + advice);
}

}  // namespace facetloc::internal
