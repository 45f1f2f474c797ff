// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "bytes/temporary_file.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <cerrno>
#include <fstream>
#include <locale>
#include <system_error>

namespace facetloc {

void createFolders(const std::filesystem::path& folder) {
  std::error_code error, ignored;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder, ignored))
    throw IoError(folder.string(), "cannot be created: " + (error ? error.message() : "it is a file"));
}

void writeAtomically(const std::filesystem::path& path,
                     const std::function<void(const std::filesystem::path& temporary)>& write) {
  files::requireFolderOf(path);
  files::requireReplaceable(path);
  TemporaryFile temporary(path);
  try {
    write(temporary.path());
  } catch (const std::filesystem::filesystem_error& e) {
    throw WriteError(path.string(), e.what());
  }
  temporary.rename();
}

void writeTextAtomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write) {
  writeAtomically(path, [&](const std::filesystem::path& temporary) {
    errno = 0;
    std::ofstream out(temporary, std::ios::binary);
    if (!out) throw WriteError(path.string(), files::lastError());
    out.imbue(std::locale::classic());
    write(out);
    out.close();
    if (!out) throw WriteError(path.string(), errno ? files::lastError() : "stream failed");
  });
}

}  // namespace facetloc
