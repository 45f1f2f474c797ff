// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace facetloc {

/** \brief A text file that grows while a program runs: what append() was given is in the file when it
 * returns, however the program ends. */
class GrowingFile {
public:
  /** \brief Begins a file, in the place of an older one. Throws IoError. */
  GrowingFile(const std::filesystem::path& path, const std::string& header);
  /** \brief Throws IoError, for example if the disk is full. */
  void append(const std::string& text);

private:
  std::filesystem::path path_;
  std::ofstream out_;
};

}  // namespace facetloc
