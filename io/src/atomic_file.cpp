// SPDX-License-Identifier: BSD-3-Clause
#include "files.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <cerrno>
#include <fstream>
#include <locale>
#include <system_error>

namespace facetloc {
namespace {

/** Removes a file at the end of its life unless it was given away by a rename. */
class TemporaryFile {
public:
  explicit TemporaryFile(std::filesystem::path path) : path_(std::move(path)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }
  void renameTo(const std::filesystem::path& target) {
    std::error_code error;
    std::filesystem::rename(path_, target, error);
    if (error) throw IoError(target.string(), "cannot be written: " + error.message());
    path_.clear();
  }

private:
  std::filesystem::path path_;
};

/** A rename would put a file in the place of a device, a pipe or a folder. */
void requireReplaceable(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw IoError(path.string(), "is there already and not a regular file");
}

}  // namespace

void createFolders(const std::filesystem::path& folder) {
  std::error_code error, ignored;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder, ignored))
    throw IoError(folder.string(), "cannot be created: " + (error ? error.message() : "it is a file"));
}

void writeAtomically(const std::filesystem::path& asked,
                     const std::function<void(const std::filesystem::path& temporary)>& write) {
  const std::filesystem::path path = files::linkedFrom(asked);
  files::requireFolderOf(path);
  requireReplaceable(path);
  TemporaryFile temporary(path.string() + ".tmp");
  try {
    write(temporary.path());
  } catch (const std::filesystem::filesystem_error& e) {
    throw IoError(path.string(), e.what());
  }
  temporary.renameTo(path);
}

void writeTextAtomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write) {
  writeAtomically(path, [&](const std::filesystem::path& temporary) {
    errno = 0;
    std::ofstream out(temporary, std::ios::binary);
    if (!out) throw IoError(path.string(), "cannot be written: " + files::lastError());
    out.imbue(std::locale::classic());
    write(out);
    out.close();
    if (!out)
      throw IoError(path.string(), "cannot be written: " + (errno ? files::lastError() : "stream failed"));
  });
}

}  // namespace facetloc
