// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/error.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <system_error>

/** \file Files and folders, private to io. */

namespace facetloc::files {

/** \brief Why the last call of the C library failed. */
inline std::string lastError() { return std::generic_category().message(errno); }

/** \brief Throws IoError unless path is a file that can be there to be read. */
inline void requireFile(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw IoError(path.string(), "does not exist");
  if (std::filesystem::is_directory(status)) throw IoError(path.string(), "is a folder, not a file");
}

/** \brief Throws IoError unless a file can be created at path as far as folders are concerned. */
inline void requireFolderOf(const std::filesystem::path& path) {
  std::error_code error;
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, error))
    throw IoError(path.string(), "its folder " + folder.string() + " does not exist");
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

/** \brief A whole text file, without the byte order mark that some editors put in front. */
inline std::string readText(const std::filesystem::path& path) {
  requireFile(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw IoError(path.string(), "cannot be opened: " + lastError());
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) throw IoError(path.string(), "cannot be read");
  constexpr const char* kByteOrderMark = "\xEF\xBB\xBF";
  if (text.rfind(kByteOrderMark, 0) == 0) text.erase(0, 3);
  return text;
}

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FilePtr = std::unique_ptr<std::FILE, Close>;

inline FilePtr open(const std::filesystem::path& path, const char* mode) {
  FilePtr file(std::fopen(path.c_str(), mode));
  if (!file) throw IoError(path.string(), "cannot be opened: " + lastError());
  return file;
}

}  // namespace facetloc::files
