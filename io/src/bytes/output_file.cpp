// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "bytes/temporary_file.h"

#include <facetloc/io/atomic_file.h>

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <locale>
#include <regex>
#include <sstream>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <system_error>

namespace facetloc {
namespace {

/** The name of a temporary file, also for the journal that SQLite keeps beside it; else empty. */
std::string temporaryOf(const std::string& name) {
  static const std::regex names("(\\.facetloc-[0-9a-f]{16}\\.tmp)(-journal)?");
  std::smatch parts;
  return std::regex_match(name, parts, names) ? parts[1].str() : "";
}

/** Is it gone, or does no living process write it? */
bool isLeft(const fs::path& temporary) {
  const files::Descriptor file(open(temporary.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  return file ? flock(file.number(), LOCK_EX | LOCK_NB) == 0 : errno == ENOENT;
}

/** Removes the temporary files of programs that were killed from a folder. */
void removeLeftovers(const fs::path& folder) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string temporary = temporaryOf(entry.path().filename().string());
    if (!temporary.empty() && fs::is_regular_file(entry.symlink_status(ignored)) &&
        isLeft(folder / temporary))
      fs::remove(entry.path(), ignored);
  }
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
    struct stat status = {};
    if (fstat(file.number(), &status) != 0) throw IoError(path.string(), files::lastError());
    if (flock(file.number(), LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK) return file;  // a file system without locks
      throw IoError(path.string(),
                    fmt::format("is being written by {}; wait until it is done", holderOf(status)));
    }
    if (isAt(status, path)) return file;
  }
}

}  // namespace

std::string readText(const fs::path& path) { return files::readText(path); }

void createFolders(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!files::isFolder(folder))
    throw IoError(folder.string(), "cannot be created: " + (error ? error.message() : "it is a file"));
}

void writeAtomically(const fs::path& path, const std::function<void(const fs::path& temporary)>& write) {
  TemporaryFile temporary(path);
  try {
    write(temporary.path());
  } catch (const fs::filesystem_error& e) {
    throw WriteError(path.string(), e.what());
  }
  temporary.rename();
}

void writeTextAtomically(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  writeAtomically(path, [&](const fs::path& temporary) {
    errno = 0;
    std::ofstream out(temporary, std::ios::binary);
    if (!out) throw WriteError(path.string(), files::lastError());
    out.imbue(std::locale::classic());
    write(out);
    out.close();
    if (!out) throw WriteError(path.string(), errno ? files::lastError() : "stream failed");
  });
}

struct GrowingFile::Impl {
  fs::path path;
  files::Descriptor file;

  void append(const std::string& text) {
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t written = write(file.number(), text.data() + done, text.size() - done);
      if (written < 0 && errno != EINTR) throw WriteError(path.string(), files::lastError());
      if (written > 0) done += static_cast<std::size_t>(written);
    }
  }
};

GrowingFile::GrowingFile(const fs::path& path, const std::string& header) {
  TemporaryFile file(path);
  impl_ = std::make_unique<Impl>(Impl{path, file.duplicate()});
  impl_->append(header);
  file.rename();
}

GrowingFile::GrowingFile(GrowingFile&&) noexcept = default;
GrowingFile& GrowingFile::operator=(GrowingFile&&) noexcept = default;
GrowingFile::~GrowingFile() = default;

void GrowingFile::append(const std::string& text) { impl_->append(text); }

std::string randomDigits() {
  std::array<unsigned char, 8> bytes;
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::system_error(errno, std::generic_category(), "random bytes");
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

files::Descriptor createNew(const fs::path& path) {
  constexpr int kMode = 0666;  // reduced by the user's mask
  return files::Descriptor(open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kMode));
}

TemporaryFile::TemporaryFile(const fs::path& target) : target_(target) {
  files::requireFolderOf(target);
  files::requireReplaceable(target);
  while (!file_) {
    const fs::path path = target.parent_path() / fmt::format(".facetloc-{}.tmp", randomDigits());
    files::Descriptor file = createNew(path);
    if (!file && errno == EEXIST) continue;
    if (!file) throw WriteError(target.string(), files::lastError());
    if (flock(file.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
      continue;  // it is being taken for one that was left
    path_ = path;
    file_ = std::move(file);
  }
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove(path_, ignored);
}

void TemporaryFile::rename() {
  std::error_code error;
  fs::rename(path_, target_, error);
  if (error) throw WriteError(target_.string(), error.message());
  path_.clear();
}

files::Descriptor TemporaryFile::duplicate() const {
  files::Descriptor copy(fcntl(file_.number(), F_DUPFD_CLOEXEC, 0));
  if (!copy) throw WriteError(target_.string(), files::lastError());
  return copy;
}

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
