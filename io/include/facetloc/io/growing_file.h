// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

namespace facetloc {

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

}  // namespace facetloc
