// SPDX-License-Identifier: BSD-3-Clause
#include "ply_header.h"

#include "files.h"
#include "shared/text.h"

#include <facetloc/io/error.h>

#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <fstream>
#include <utility>

namespace facetloc {
namespace {

constexpr std::size_t kLongestHeader = 65536;  // [bytes]

constexpr std::array<std::pair<std::string_view, std::uint64_t>, 16> kTypes{{{"char", 1},
                                                                             {"int8", 1},
                                                                             {"uchar", 1},
                                                                             {"uint8", 1},
                                                                             {"short", 2},
                                                                             {"int16", 2},
                                                                             {"ushort", 2},
                                                                             {"uint16", 2},
                                                                             {"int", 4},
                                                                             {"int32", 4},
                                                                             {"uint", 4},
                                                                             {"uint32", 4},
                                                                             {"float", 4},
                                                                             {"float32", 4},
                                                                             {"double", 8},
                                                                             {"float64", 8}}};

/** Bytes of a type of PLY; 0 for another word. */
std::uint64_t sizeOf(std::string_view type) {
  for (const auto& [name, size] : kTypes)
    if (name == type) return size;
  return 0;
}

/** The least size of the data after the header. */
class PlyHeader {
public:
  explicit PlyHeader(std::string path) : path_(std::move(path)) {}

  /** \return false after the last line. */
  bool take(std::string_view line) {
    const std::vector<std::string_view> words = text::words(line);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") return true;
    if (words[0] == "end_header") return false;
    if (words[0] == "format" && words.size() == 3)
      ascii_ = words[1] == "ascii";
    else if (words[0] == "element" && words.size() == 3)
      beginElement(words[2]);
    else if (words[0] == "property" && words.size() >= 3)
      addProperty(words);
    else
      throw IoError(path_, fmt::format("has the line '{}' in its header, which is none of PLY", line));
    return true;
  }
  std::uint64_t leastBytes() const { return least_ + count_ * item_; }

private:
  void beginElement(std::string_view count) {
    constexpr std::uint64_t kMost = 1ull << 31;  // PCL counts in 32 bits
    const auto number = text::to<std::uint64_t>(count);
    if (!number || *number >= kMost)
      throw IoError(path_, fmt::format("has '{}' as a number of elements in its header", count));
    least_ += count_ * item_;
    count_ = *number, item_ = 0;
  }
  void addProperty(const std::vector<std::string_view>& words) {
    const bool is_list = words[1] == "list";
    const std::uint64_t size = sizeOf(is_list ? words[2] : words[1]);
    if (size == 0 || words.size() != (is_list ? 5 : 3) || (is_list && sizeOf(words[3]) == 0))
      throw IoError(path_, fmt::format("has a property in its header whose type PLY does not know: {}",
                                       fmt::join(words, " ")));
    item_ += ascii_ ? 2 : size;  // a digit and a blank; a list has its length at least
  }

  std::string path_;
  bool ascii_ = false;
  std::uint64_t least_ = 0, count_ = 0, item_ = 0;
};

}  // namespace

void requireSoundPly(const std::filesystem::path& path) {
  files::requireRegularFile(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw IoError(path.string(), "cannot be opened: " + files::lastError());
  std::string start(kLongestHeader, '\0');
  in.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(in.gcount()));
  if (text::trimmed(std::string_view(start).substr(0, start.find('\n'))) != "ply")
    throw IoError(path.string(), "is no PLY file: its first line is not 'ply'");
  PlyHeader header(path.string());
  std::size_t at = start.find('\n');
  for (bool more = true; more;) {
    const std::size_t end = at == std::string::npos ? at : start.find('\n', at + 1);
    if (end == std::string::npos) throw IoError(path.string(), "has no end of its PLY header");
    more = header.take(text::trimmed(std::string_view(start).substr(at + 1, end - at - 1)));
    at = end;
  }
  const std::uint64_t rest = std::filesystem::file_size(path) - at;
  if (header.leastBytes() > rest)
    throw IoError(path.string(),
                  fmt::format("is cut off: its header promises at least {} bytes, {} are there",
                              header.leastBytes(), rest));
}

}  // namespace facetloc
