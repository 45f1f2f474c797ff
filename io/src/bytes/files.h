// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace facetloc {
namespace fs = std::filesystem;

namespace files {

/** \brief Why the last call of the C library failed. */
inline std::string lastError() { return std::generic_category().message(errno); }

/** \brief Is something there? Like the next two, false where nothing can be looked at. */
inline bool isThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}
inline bool isFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}
inline bool isFolder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/** \brief Throws IoError if a clone of a repository has a pointer of Git LFS or git-annex, a link or a few
 * lines of text, in place of the file. */
inline void requireNoPointer(const fs::path& path) {
  constexpr std::uintmax_t kLargest = 32768;  // bytes, by the specifications
  std::error_code error;
  std::string begin;
  if (fs::is_symlink(path, error) && !isThere(path)) {
    begin = fs::read_symlink(path, error).string();
  } else if (isFile(path) && fs::file_size(path, error) < kLargest) {
    begin.resize(27);
    std::ifstream(path, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  }
  if (begin == "version https://git-lfs.git")
    throw IoError(path.string(), "is a pointer of Git LFS, not the file itself: git lfs pull fetches it");
  if (begin.rfind("/annex/objects/", 0) == 0 || begin.find(".git/annex/objects/") != std::string::npos)
    throw IoError(path.string(), "is a pointer of git-annex, not the file itself: git annex get fetches it");
}

/** \brief Throws IoError unless path is a file that can be there to be read from its beginning to its end, or
 * a pipe. */
inline void requireFile(const fs::path& path) {
  std::error_code error;
  const auto status = fs::status(path, error);
  requireNoPointer(path);
  if (!fs::exists(status)) throw IoError(path.string(), "does not exist");
  if (fs::is_directory(status)) throw IoError(path.string(), "is a folder, not a file");
  if (!fs::is_regular_file(status) && !fs::is_fifo(status))
    throw IoError(path.string(), "is a device or a socket, not a file");
}

/** \brief Throws IoError unless any place of the file can be read at any time: a pipe will not do. */
inline void requireRegularFile(const fs::path& path) {
  requireFile(path);
  if (fs::is_fifo(path)) throw IoError(path.string(), "is a pipe, not a file");
}

/** \brief A rename would put a file in the place of a device, a pipe or a folder. Throws IoError. */
inline void requireReplaceable(const fs::path& path) {
  std::error_code error;
  const auto status = fs::status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw IoError(path.string(), "exists already and is not a regular file");
}

/** \brief Throws IoError unless a file can be created at path as far as folders are concerned. */
inline void requireFolderOf(const fs::path& path) {
  const auto folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!isFolder(folder))
    throw IoError(path.string(), fmt::format("its folder {} does not exist", folder.string()));
}

/** \brief Where a file would be written: a link is kept, and its target, which may not exist yet,
 * is replaced. */
inline fs::path linkedFrom(fs::path path) {
  constexpr int kMostLinks = 40;  // as the kernel's
  std::error_code error;
  for (int i = 0; i < kMostLinks && fs::is_symlink(path, error); ++i)
    path = path.parent_path() / fs::read_symlink(path, error);
  return path;
}

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FilePtr = std::unique_ptr<std::FILE, Close>;

/** \brief Opens a file to be read. A pipe without a writer ends at once instead of blocking. */
inline FilePtr open(const fs::path& path) {
  const int number = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  FilePtr file(number < 0 ? nullptr : fdopen(number, "rb"));
  if (!file) throw IoError(path.string(), "cannot be opened: " + lastError());
  fcntl(number, F_SETFL, fcntl(number, F_GETFL) & ~O_NONBLOCK);  // who writes may take their time
  return file;
}

/** \brief UTF-8 of UTF-16, as editors and shells of Windows write it: a code point that is half is replaced.
 */
inline std::string fromUtf16(std::string_view bytes, bool big_endian) {
  constexpr std::uint32_t kReplacement = 0xFFFD;
  std::string out;
  const auto unit = [&](std::size_t i) {
    const auto first = static_cast<std::uint8_t>(bytes[i]), second = static_cast<std::uint8_t>(bytes[i + 1]);
    return static_cast<std::uint32_t>(big_endian ? first << 8 | second : second << 8 | first);
  };
  const auto isHigh = [](std::uint32_t u) { return u >= 0xD800 && u < 0xDC00; };
  const auto isLow = [](std::uint32_t u) { return u >= 0xDC00 && u < 0xE000; };
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    std::uint32_t code = unit(i);
    if (isHigh(code) && i + 3 < bytes.size() && isLow(unit(i + 2))) {
      code = 0x10000 + ((code - 0xD800) << 10) + (unit(i + 2) - 0xDC00);
      i += 2;
    } else if (isHigh(code) || isLow(code)) {
      code = kReplacement;
    }
    const int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;  // bytes behind the first
    constexpr std::uint32_t kFirst[] = {0, 0xC0, 0xE0, 0xF0};
    out += static_cast<char>(kFirst[more] | code >> 6 * more);
    for (int k = more - 1; k >= 0; --k) out += static_cast<char>(0x80 | (code >> 6 * k & 0x3F));
  }
  return out;
}

/** \brief All bytes of a file. */
inline std::string readBytes(const fs::path& path) {
  requireFile(path);
  const FilePtr file = open(path);
  std::string bytes;
  std::array<char, 1 << 16> part;
  while (const std::size_t size = std::fread(part.data(), 1, part.size(), file.get()))
    bytes.append(part.data(), size);
  if (std::ferror(file.get())) throw IoError(path.string(), "cannot be read: " + lastError());
  return bytes;
}

/** \brief Text as UTF-8, without the byte order mark that some editors put in front; UTF-16 is known by its
 * mark. Bytes without a mark are left alone. */
inline std::string asUtf8(std::string bytes) {
  if (bytes.rfind("\xEF\xBB\xBF", 0) == 0) return bytes.erase(0, 3);
  const bool little = bytes.rfind("\xFF\xFE", 0) == 0, big = bytes.rfind("\xFE\xFF", 0) == 0;
  return little || big ? fromUtf16(std::string_view(bytes).substr(2), big) : bytes;
}

/** \brief A whole text file as UTF-8 (asUtf8()), in which lines end with "\n" or "\r\n". UTF-16 without a
 * mark is known by its first two characters. */
inline std::string readText(const fs::path& path) {
  std::string text = asUtf8(readBytes(path));
  const auto zeros = [&text](std::size_t i) { return text.size() > 3 ? !text[i] + !text[i + 2] : 1; };
  if (zeros(0) + zeros(1) == 2 && zeros(0) != 1) text = fromUtf16(text, zeros(0) == 2);
  if (text.find('\n') == std::string::npos) std::replace(text.begin(), text.end(), '\r', '\n');
  return text;
}

/** \brief The sorted entries of a folder for which a condition holds; none of a folder that cannot be read.
 */
template <typename Condition>
std::vector<fs::path> entriesOf(const fs::path& folder, const Condition& holds) {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (holds(entry)) found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

/** \brief Calls use(line) with each line of a text; its std::invalid_argument becomes an IoError with the
 * number of the line. */
template <typename Use>
void forEachLine(std::string_view content, const std::string& path, const Use& use) {
  int number = 0;
  for (const std::string_view line : text::lines(content)) try {
      ++number;
      use(line);
    } catch (const std::invalid_argument& e) {
      throw IoError(path, fmt::format("line {}: {}", number, e.what()));
    }
}

}  // namespace files

namespace internal {

inline bool endsWith(const std::string& name, const std::string& ending) {
  return name.size() >= ending.size() &&
         name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}
using text::lowerExtension;
inline bool isPng(const fs::path& path) { return lowerExtension(path) == ".png"; }

/** \brief Adds a sentence, behind a semicolon, unless it is empty. */
inline void addSentence(const std::string& sentence, std::string& sentences) {
  if (!sentence.empty()) sentences += (sentences.empty() ? "" : "; ") + sentence;
}

}  // namespace internal
}  // namespace facetloc
