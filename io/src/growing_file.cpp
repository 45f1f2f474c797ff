// SPDX-License-Identifier: BSD-3-Clause
#include "files.h"

#include <facetloc/io/growing_file.h>

namespace facetloc {

GrowingFile::GrowingFile(const std::filesystem::path& path, const std::string& header)
    : path_(path), out_(path, std::ios::binary | std::ios::trunc) {
  if (!out_) throw IoError(path_.string(), "cannot be written: " + files::lastError());
  append(header);
}

void GrowingFile::append(const std::string& text) {
  errno = 0;
  out_ << text << std::flush;
  if (!out_)
    throw IoError(path_.string(), "cannot be written: " + (errno ? files::lastError() : "stream failed"));
}

}  // namespace facetloc
