// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/descriptor.h"
#include "bytes/files.h"
#include "bytes/temporary_file.h"

#include <facetloc/io/output_lock.h>

#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

struct stat statusOf(const files::Descriptor& file, const fs::path& path) {
  struct stat status = {};
  if (fstat(file.number(), &status) != 0) throw IoError(path.string(), files::lastError());
  return status;
}

/** "process 4711", if the kernel's list of locks knows it: a line of it reads
 * "1: FLOCK ADVISORY WRITE 4711 08:01:1311 0 EOF", with the device in hexadecimal digits. */
std::string holderOf(const struct stat& status) {
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);
    std::string number, kind, advisory, mode;
    long process = 0;
    unsigned major = 0, minor = 0;
    unsigned long long inode = 0;
    char colon = 0;
    words >> number >> kind >> advisory >> mode >> process >> std::hex >> major >> colon >> minor >> colon >>
        std::dec >> inode;
    if (words && kind == "FLOCK" && major == major(status.st_dev) && minor == minor(status.st_dev) &&
        inode == status.st_ino)
      return fmt::format("process {}", process);
  }
  return "another process";
}

/** False if somebody has put another file in its place meanwhile. */
bool isAt(const struct stat& status, const fs::path& path) {
  struct stat now = {};
  return stat(path.c_str(), &now) == 0 && now.st_dev == status.st_dev && now.st_ino == status.st_ino;
}

files::Descriptor locked(const fs::path& path, int flags) {
  constexpr int kMode = 0666;  // reduced by the user's mask
  for (;;) {
    files::Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | flags, kMode));
    if (!file) throw WriteError(path.string(), files::lastError());
    const struct stat status = statusOf(file, path);
    if (flock(file.number(), LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK) return file;  // a file system without locks
      throw IoError(path.string(),
                    fmt::format("is being written by {}; wait until it is done", holderOf(status)));
    }
    if (isAt(status, path)) return file;
  }
}

}  // namespace

struct OutputLock::Impl {
  fs::path file;  // empty for a folder
  files::Descriptor held;
};

OutputLock::OutputLock(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OutputLock::OutputLock(OutputLock&&) noexcept = default;
OutputLock& OutputLock::operator=(OutputLock&&) noexcept = default;

OutputLock::~OutputLock() {
  if (!impl_ || impl_->file.empty()) return;
  struct stat status = {};
  const bool is_empty = fstat(impl_->held.number(), &status) == 0 && status.st_size == 0;
  std::error_code ignored;
  if (is_empty && isAt(status, impl_->file)) fs::remove(impl_->file, ignored);
}

OutputLock OutputLock::ofFolder(const fs::path& folder) {
  OutputLock lock(std::make_unique<Impl>(Impl{{}, locked(folder, O_DIRECTORY)}));
  removeLeftovers(folder);
  return lock;
}

OutputLock OutputLock::ofFile(const fs::path& asked) {
  const fs::path file = files::linkedFrom(asked);
  files::requireFolderOf(file);
  files::requireReplaceable(file);
  OutputLock lock(std::make_unique<Impl>(Impl{file, locked(file, O_CREAT)}));
  removeLeftovers(file.has_parent_path() ? file.parent_path() : fs::path("."));
  return lock;
}

}  // namespace facetloc
