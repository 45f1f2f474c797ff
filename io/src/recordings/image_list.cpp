// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/image_list.h"

#include "files.h"
#include "shared/text.h"

#include <facetloc/io/error.h>
#include <facetloc/io/segment_file.h>

#include <algorithm>
#include <cctype>
#include <fmt/format.h>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDepth = "depth";  // of an image's ending, or its folder

/** frame-000000.depth.png, beside frame-000000.color.png. */
bool isNamedDepth(const ListedImage& image) {
  return image.path.stem().extension() == std::string(".") + kDepth;
}

bool isInDepthFolder(std::string_view path) {
  const fs::path folder = fs::path(path).parent_path();
  return std::any_of(folder.begin(), folder.end(), [](const fs::path& part) { return part == kDepth; });
}

class ListParser {
public:
  explicit ListParser(const fs::path& list) : list_(list) {}

  std::vector<ListedImage> parse(std::string_view content) {
    for (const std::string_view line : text::lines(content)) {
      ++line_;
      const auto entry = text::trimmed(line);
      if (!entry.empty() && entry.front() != '#') add(entry);
    }
    return images_;
  }

private:
  [[noreturn]] void fail(const std::string& cause) const {
    throw IoError(list_.string(), fmt::format("line {}: {}", line_, cause));
  }

  void add(std::string_view entry) {
    const auto words = text::words(entry);
    const auto stamp = [&words](std::size_t i) { return text::to<double>(words[i]); };
    if (words.size() == 2 && stamp(0))
      put(words[1], stamp(0));
    else if (words.size() == 4 && stamp(0) && stamp(2))
      putEither({{words[1], stamp(0)}, {words[3], stamp(2)}});
    else
      put(entry, {});
  }

  using Entry = std::pair<std::string_view, std::optional<double>>;

  void putEither(const std::vector<Entry>& pair) {
    const bool first = isInDepthFolder(pair[0].first), second = isInDepthFolder(pair[1].first);
    if (first == second) fail("names two images, of which one has to be in a folder called depth");
    const Entry& depth = pair[first ? 0 : 1];
    put(depth.first, depth.second);
  }

  void put(std::string_view entry, std::optional<double> stamp) {
    const fs::path path = list_.parent_path() / fs::path(entry);  // an absolute entry stays as it is
    if (!isImage(path)) fail(fmt::format("{} is neither a .png nor a .pcd file", entry));
    if (!images_.empty() && images_.front().stamp.has_value() != stamp.has_value())
      fail(fmt::format("has {} time stamp, unlike the lines before it", stamp ? "a" : "no"));
    images_.push_back({path, stamp});  // one that is missing fails when it is read, and stops no other
  }

  fs::path list_;
  int line_ = 0;
  std::vector<ListedImage> images_;
};

}  // namespace

bool endsWith(const std::string& name, const std::string& ending) {
  return name.size() >= ending.size() &&
         name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

std::string lowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

std::string frameName(const fs::path& path) {
  const std::string name = path.filename().string();
  if (isSegmentFile(path)) return name.substr(0, name.size() - std::string(kSegmentEnding).size());
  return path.stem().string();
}

bool isPng(const fs::path& path) { return lowerExtension(path) == ".png"; }
bool isImage(const fs::path& path) { return isPng(path) || lowerExtension(path) == ".pcd"; }
bool isImageList(const fs::path& path) {
  return lowerExtension(path) == ".txt" || lowerExtension(path) == ".lst";
}

std::vector<ListedImage> imagesOfFolder(const fs::path& folder) {
  std::vector<ListedImage> images;
  try {
    for (const auto& entry : fs::directory_iterator(folder)) {
      const bool hidden = entry.path().filename().string().front() == '.';
      // A link that leads nowhere is an image that cannot be read.
      if (!hidden && isImage(entry.path()) && !entry.is_directory()) images.push_back({entry.path()});
    }
  } catch (const fs::filesystem_error& e) {
    throw IoError(folder.string(), e.what());
  }
  const auto keepIfAny = [&images](auto counts) {
    if (std::any_of(images.begin(), images.end(), counts))
      images.erase(std::remove_if(images.begin(), images.end(), std::not_fn(counts)), images.end());
  };
  keepIfAny([](const ListedImage& image) { return isSegmentFile(image.path); });
  keepIfAny(isNamedDepth);
  std::sort(images.begin(), images.end(),
            [](const ListedImage& a, const ListedImage& b) { return a.path < b.path; });
  return images;
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

}  // namespace facetloc::internal
