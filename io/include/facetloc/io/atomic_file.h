// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <ostream>
#include <string>

namespace facetloc {

/** \brief A whole text file as UTF-8, without a byte order mark; its lines end with "\n" or "\r\n". Throws
 * IoError, also for a folder, a device, or a pointer in place of a large file. */
std::string readText(const std::filesystem::path& path);

/** \brief Creates a folder and those above it, if they are not there. Throws IoError. */
void createFolders(const std::filesystem::path& folder);

/** \brief Writes a file so that it is there whole or not at all: path.tmp, then renamed.
 *
 * \param write gets the path of the temporary file and writes it. Throws IoError if that fails (full disk,
 * missing folder); the temporary file is then removed and an older file at path is untouched. */
void writeAtomically(const std::filesystem::path& path,
                     const std::function<void(const std::filesystem::path& temporary)>& write);

/** \brief The same for text: write fills a stream in the classic locale; a stream that went bad is an
 * IoError. */
void writeTextAtomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

/** \brief A text file that grows while a program runs: text given to append() is in the file when it
 * returns, however the program ends. */
class GrowingFile {
public:
  /** \brief Begins a new file, in the place of an older one: a link there is replaced, not followed. The file
   * appears with its header only, or not at all. Throws WriteError. */
  GrowingFile(const std::filesystem::path& path, const std::string& header);
  GrowingFile(GrowingFile&&) noexcept;
  GrowingFile& operator=(GrowingFile&&) noexcept;
  ~GrowingFile();
  /** \brief Throws WriteError, for example if the disk is full. */
  void append(const std::string& text);

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** \brief Keeps other programs of this library from writing the same file or folder, for as long as it lives.
 *
 * The lock is on the file or folder itself and dies with its process: nothing is left behind that would have
 * to be cleared away. Temporary files that killed programs have left are removed. Readers are not kept out.
 */
class OutputLock {
public:
  /** \brief Lock of a folder that is there. Throws IoError, which says who writes to it. */
  static OutputLock ofFolder(const std::filesystem::path& folder);
  /** \brief Lock of a file, which is empty if it was not there. Throws IoError, which says who writes it. */
  static OutputLock ofFile(const std::filesystem::path& file);

  OutputLock(OutputLock&&) noexcept;
  OutputLock& operator=(OutputLock&&) noexcept;
  /** \brief Removes a file that is empty: nothing was written to it. */
  ~OutputLock();

private:
  struct Impl;
  explicit OutputLock(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace facetloc
