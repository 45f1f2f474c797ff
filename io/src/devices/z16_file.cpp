// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "devices/z16_buffers.h"

#include <facetloc/io/error.h>

#include <fstream>
#include <vector>

namespace facetloc::internal {
namespace {

constexpr double kUsualInterval = 1.0 / 30;  // [s]

/** Frames without gaps between rows or frames. */
class Z16File : public Z16Buffers {
public:
  Z16File(const std::filesystem::path& path, int width, int height)
      : layout_{width, height, 2 * static_cast<std::size_t>(width)} {
    files::requireRegularFile(path);
    if (width <= 0 || height <= 0)
      throw IoError(path.string(), "does not say how large its images are: give a camera.ini");
    in_.open(path, std::ios::binary);
    if (!in_) throw IoError(path.string(), "cannot be opened: " + files::lastError());
    if (std::filesystem::file_size(path) == 0) throw IoError(path.string(), "is empty");
  }

  Z16Layout layout() const override { return layout_; }
  bool atEnd() const override { return ended_; }
  bool isLive() const override { return false; }

  bool take(FrameSource::Patience, const std::function<void(const Z16Buffer&)>& use) override {
    bytes_.resize(layout_.bytes());
    in_.read(reinterpret_cast<char*>(bytes_.data()), static_cast<std::streamsize>(bytes_.size()));
    const auto n = static_cast<std::size_t>(in_.gcount());
    ended_ = n == 0;
    if (!ended_) use({bytes_.data(), n, kUsualInterval * static_cast<double>(frames_++)});
    ended_ = ended_ || in_.peek() == std::ifstream::traits_type::eof();
    return n > 0;
  }

private:
  const Z16Layout layout_;
  std::ifstream in_;
  std::vector<unsigned char> bytes_;
  std::uint64_t frames_ = 0;
  bool ended_ = false;
};

}  // namespace

std::vector<std::uint16_t> depthsOf(const unsigned char* bytes, const Z16Layout& layout) {
  std::vector<std::uint16_t> depths;
  depths.reserve(static_cast<std::size_t>(layout.width) * layout.height);
  for (int row = 0; row < layout.height; ++row) {
    const unsigned char* at = bytes + layout.bytes_per_row * static_cast<std::size_t>(row);
    for (int column = 0; column < layout.width; ++column, at += 2)
      depths.push_back(static_cast<std::uint16_t>(at[0] | at[1] << 8));
  }
  return depths;
}

std::unique_ptr<Z16Buffers> openZ16File(const std::filesystem::path& path, int width, int height) {
  return std::make_unique<Z16File>(path, width, height);
}

}  // namespace facetloc::internal
