// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/temporary_file.h"

#include "bytes/files.h"

#include <array>
#include <cstdio>
#include <fcntl.h>
#include <fmt/format.h>
#include <regex>
#include <sys/file.h>
#include <sys/random.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

std::string randomDigits() {
  std::array<unsigned char, 8> bytes;
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::system_error(errno, std::generic_category(), "random bytes");
  std::string digits;
  for (const unsigned char byte : bytes) {
    constexpr const char* kDigits = "0123456789abcdef";
    digits += kDigits[byte >> 4];
    digits += kDigits[byte & 15];
  }
  return digits;
}

files::Descriptor createNew(const fs::path& path) {
  constexpr int kMode = 0666;  // reduced by the user's mask
  return files::Descriptor(open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kMode));
}

TemporaryFile::TemporaryFile(const fs::path& target) : target_(target) {
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

void removeLeftovers(const fs::path& folder) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string temporary = temporaryOf(entry.path().filename().string());
    if (!temporary.empty() && fs::is_regular_file(entry.symlink_status(ignored)) &&
        isLeft(folder / temporary))
      fs::remove(entry.path(), ignored);
  }
}

}  // namespace facetloc
