// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

namespace facetloc {

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
