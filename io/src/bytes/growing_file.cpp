// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/descriptor.h"
#include "bytes/files.h"
#include "bytes/temporary_file.h"

#include <facetloc/io/growing_file.h>

namespace facetloc {

struct GrowingFile::Impl {
  std::filesystem::path path;
  files::Descriptor file;

  void append(const std::string& text) {
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t written = write(file.number(), text.data() + done, text.size() - done);
      if (written < 0 && errno != EINTR) throw WriteError(path.string(), files::lastError());
      if (written > 0) done += static_cast<std::size_t>(written);
    }
  }
};

GrowingFile::GrowingFile(const std::filesystem::path& path, const std::string& header) {
  files::requireFolderOf(path);
  files::requireReplaceable(path);
  TemporaryFile file(path);
  impl_ = std::make_unique<Impl>(Impl{path, file.duplicate()});
  impl_->append(header);
  file.rename();
}

GrowingFile::GrowingFile(GrowingFile&&) noexcept = default;
GrowingFile& GrowingFile::operator=(GrowingFile&&) noexcept = default;
GrowingFile::~GrowingFile() = default;

void GrowingFile::append(const std::string& text) { impl_->append(text); }

}  // namespace facetloc
