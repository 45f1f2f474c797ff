// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace facetloc {

/** \brief A file or folder could not be read or written; the message names it and the cause. */
class IoError : public std::runtime_error {
public:
  IoError(const std::string& path, const std::string& cause)
      : std::runtime_error(path + ": " + cause), path_(path), cause_(cause) {}

  const std::string& path() const { return path_; }
  const std::string& cause() const { return cause_; }

private:
  std::string path_, cause_;
};

/** \brief An output could not be written: the disk is full, its folder is gone. The next write would fail in
 * the same way, so that no work goes on after it. */
class WriteError : public IoError {
public:
  WriteError(const std::string& path, const std::string& why)
      : IoError(path, "cannot be written: " + why), why_(why) {}

  /** \brief Cause in the system's words. */
  const std::string& why() const { return why_; }

private:
  std::string why_;
};

}  // namespace facetloc
