// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <unistd.h>
#include <utility>

namespace facetloc {
namespace files {

/** \brief An open file of the operating system, closed at the end of its life. */
class Descriptor {
public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }

  int number() const { return number_; }
  explicit operator bool() const { return number_ >= 0; }

private:
  int number_;
};

}  // namespace files

/** \brief 16 hexadecimal digits that are impossible to guess. */
std::string randomDigits();
/** \brief A new file: an existing one, be it a link, is an error, EEXIST in errno. */
files::Descriptor createNew(const std::filesystem::path& path);

/** \brief A new, empty file beside the one that it will replace, removed at the end of its life unless it was
 * renamed.
 *
 * Its name is random and the file is new (O_EXCL), so that no file or link can be put in its place
 * beforehand. It is locked for as long as it is open, and the lock dies with its process: a file of a killed
 * program is one that no process holds. */
class TemporaryFile {
public:
  /** \brief Throws IoError, which names the target: its folder is not there, it is no file, or the disk is
   * full. */
  explicit TemporaryFile(const std::filesystem::path& target);
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile();

  const std::filesystem::path& path() const { return path_; }
  /** \brief Puts it in the place of the target. A link there is replaced, not followed. */
  void rename();
  /** \brief To go on writing after it. Throws WriteError. */
  files::Descriptor duplicate() const;

private:
  std::filesystem::path target_;
  std::filesystem::path path_;  // empty once it is renamed
  files::Descriptor file_;
};

}  // namespace facetloc
