// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/error.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <system_error>

/** \file
 * Files and folders, private to io. */

namespace facetloc::files {

/** \brief Why the last call of the C library failed. */
inline std::string lastError() { return std::generic_category().message(errno); }

/** \brief Throws IoError unless path is a file that can be there to be read from its beginning to its end, or
 * a pipe. */
inline void requireFile(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw IoError(path.string(), "does not exist");
  if (std::filesystem::is_directory(status)) throw IoError(path.string(), "is a folder, not a file");
  if (!std::filesystem::is_regular_file(status) && !std::filesystem::is_fifo(status))
    throw IoError(path.string(), "is a device or a socket, not a file");
}

/** \brief Throws IoError unless any place of the file can be read at any time: a pipe will not do. */
inline void requireRegularFile(const std::filesystem::path& path) {
  requireFile(path);
  if (std::filesystem::is_fifo(path)) throw IoError(path.string(), "is a pipe, not a file");
}

/** \brief A rename would put a file in the place of a device, a pipe or a folder. Throws IoError. */
inline void requireReplaceable(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw IoError(path.string(), "is there already and not a regular file");
}

/** \brief Throws IoError unless a file can be created at path as far as folders are concerned. */
inline void requireFolderOf(const std::filesystem::path& path) {
  std::error_code error;
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, error))
    throw IoError(path.string(), fmt::format("its folder {} does not exist", folder.string()));
}

/** \brief Where a file would be written: a link stays one, and what it leads to, which may not be there yet,
 * is replaced. */
inline std::filesystem::path linkedFrom(std::filesystem::path path) {
  constexpr int kMostLinks = 40;  // as the kernel's
  std::error_code error;
  for (int i = 0; i < kMostLinks && std::filesystem::is_symlink(path, error); ++i)
    path = path.parent_path() / std::filesystem::read_symlink(path, error);
  return path;
}

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FilePtr = std::unique_ptr<std::FILE, Close>;

/** \brief Opens a file to be read. Of a pipe that nobody writes to, that is the end, not a wait for ever. */
inline FilePtr open(const std::filesystem::path& path) {
  const int number = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  FilePtr file(number < 0 ? nullptr : fdopen(number, "rb"));
  if (!file) throw IoError(path.string(), "cannot be opened: " + lastError());
  fcntl(number, F_SETFL, fcntl(number, F_GETFL) & ~O_NONBLOCK);  // who writes may take their time
  return file;
}

/** \brief A whole text file, without the byte order mark that some editors put in front. */
inline std::string readText(const std::filesystem::path& path) {
  requireFile(path);
  const FilePtr file = open(path);
  std::string text;
  std::array<char, 1 << 16> part;
  while (const std::size_t size = std::fread(part.data(), 1, part.size(), file.get()))
    text.append(part.data(), size);
  if (std::ferror(file.get())) throw IoError(path.string(), "cannot be read: " + lastError());
  constexpr const char* kByteOrderMark = "\xEF\xBB\xBF";
  if (text.rfind(kByteOrderMark, 0) == 0) text.erase(0, 3);
  return text;
}

}  // namespace facetloc::files
