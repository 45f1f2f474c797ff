// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "images/depth_file.h"

#include <cstdarg>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <tiffio.h>

namespace facetloc {
namespace {

constexpr tmsize_t kMostMemory = 1 << 28;  // size of one piece of libtiff's [bytes]

/** The last thing that libtiff had to say of a file. */
int keep(TIFF*, void* complaint, const char*, const char* format, va_list arguments) {
  std::array<char, 256> line{};
  std::vsnprintf(line.data(), line.size(), format, arguments);
  *static_cast<std::string*>(complaint) = line.data();
  return 1;
}
int ignore(TIFF*, void*, const char*, const char*, va_list) { return 1; }

struct CloseTiff {
  void operator()(TIFF* file) const { TIFFClose(file); }
  void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};

/** Rows of values, one after the other. */
class TiffReader {
public:
  explicit TiffReader(const fs::path& path) : path_(path.string()) {
    files::requireRegularFile(path);
    const std::unique_ptr<TIFFOpenOptions, CloseTiff> options(TIFFOpenOptionsAlloc());
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMostMemory);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep, &complaint_);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), ignore, nullptr);
    file_.reset(TIFFOpenExt(path_.c_str(), "r", options.get()));
    if (!file_) fail("is no TIFF file, or a corrupt one");
  }

  StoredDepth read() {
    const auto width = field<std::uint32_t>(TIFFTAG_IMAGEWIDTH),
               height = field<std::uint32_t>(TIFFTAG_IMAGELENGTH);
    const auto bits = field<std::uint16_t>(TIFFTAG_BITSPERSAMPLE),
               kind = field<std::uint16_t>(TIFFTAG_SAMPLEFORMAT);
    requireSize(path_, width, height);
    if (field<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL) != 1)
      throw IoError(
          path_, "has several channels; one channel of 16 bits, or of 32 or 64 of floating point, is read");
    if (TIFFIsTiled(file_.get()))
      throw IoError(path_, "is made of tiles, which are not read; of strips it is: tiffcp -s IN.tif OUT.tif");
    StoredDepth values{static_cast<int>(width), static_cast<int>(height), {}, {}};
    if (kind == SAMPLEFORMAT_IEEEFP && bits == 32)
      rows<float>(values.metres, width, height);
    else if (kind == SAMPLEFORMAT_IEEEFP && bits == 64)
      rows<double>(values.metres, width, height);
    else if (kind != SAMPLEFORMAT_IEEEFP && bits == 16)
      rows<std::uint16_t>(values.numbers, width, height);
    else
      throw IoError(path_, fmt::format("has {} bits per pixel, not 16, or 32 or 64 of floating point", bits));
    return values;
  }

private:
  [[noreturn]] void fail(const std::string& cause) const {
    throw IoError(path_, complaint_.empty() ? cause : cause + ": " + complaint_);
  }

  template <typename T>
  T field(std::uint32_t tag) const {
    T value{};
    TIFFGetFieldDefaulted(file_.get(), tag, &value);
    return value;
  }

  /** Memory grows with the data read, not with the size promised. */
  template <typename T, typename Out>
  void rows(std::vector<Out>& out, std::uint32_t width, std::uint32_t height) {
    const auto line = static_cast<std::size_t>(TIFFScanlineSize64(file_.get()));
    if (line != sizeof(T) * width) fail("is a corrupt TIFF file: its rows are of another size");
    std::vector<T> row(width);
    for (std::uint32_t v = 0; v < height; ++v) {
      if (TIFFReadScanline(file_.get(), row.data(), v, 0) != 1) fail("is a truncated or corrupt TIFF file");
      for (const T value : row) out.push_back(static_cast<Out>(value));
    }
  }

  std::string path_, complaint_;
  std::unique_ptr<TIFF, CloseTiff> file_;
};

}  // namespace

StoredDepth readTiff(const fs::path& path) { return TiffReader(path).read(); }

}  // namespace facetloc
