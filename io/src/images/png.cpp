// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "images/depth_file.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/png.h>

#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <fmt/format.h>
#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

constexpr int kZlibLevel = 2;  // depth and labels shrink hardly more at higher, slower levels
constexpr std::size_t kSignatureSize = 8;

/** The message of libpng when it gave up. Plain memory, since longjmp runs no destructors. */
struct Complaint {
  char text[128] = "";
};

void onError(png_structp png, png_const_charp message) {
  auto* complaint = static_cast<Complaint*>(png_get_error_ptr(png));
  std::snprintf(complaint->text, sizeof complaint->text, "%s", message);
  png_longjmp(png, 1);
}

void onWarning(png_structp, png_const_charp) {}

/** A piece of work with libpng. libpng may leave it by longjmp: it must own nothing. */
using Step = void (*)(png_structp, png_infop, void* context);

/** The one place where setjmp is called: no object with a destructor lives between here and libpng. */
bool succeeds(png_structp png, png_infop info, Step step, void* context) {
  if (setjmp(png_jmpbuf(png))) return false;
  step(png, info, context);
  return true;
}

/** Owns libpng's structures for one file. */
class Codec {
public:
  enum class Kind { kRead, kWrite };

  Codec(Kind kind, std::FILE* file, std::string path) : kind_(kind), path_(std::move(path)) {
    const auto create = kind == Kind::kRead ? png_create_read_struct : png_create_write_struct;
    png_ = create(PNG_LIBPNG_VER_STRING, &complaint_, onError, onWarning);
    info_ = png_ ? png_create_info_struct(png_) : nullptr;
    if (!info_) {
      destroy();
      throw IoError(path_, "libpng cannot start");
    }
    png_init_io(png_, file);
  }
  Codec(const Codec&) = delete;
  Codec& operator=(const Codec&) = delete;
  ~Codec() { destroy(); }

  void run(Step step, void* context) {
    errno = 0;
    if (succeeds(png_, info_, step, context)) return;
    if (kind_ == Kind::kWrite) throw WriteError(path_, errno ? files::lastError() : complaint_.text);
    throw IoError(path_, fmt::format("is a truncated or corrupt PNG: {}", complaint_.text));
  }

private:
  void destroy() {
    if (kind_ == Kind::kRead) png_destroy_read_struct(&png_, &info_, nullptr);
    if (kind_ == Kind::kWrite) png_destroy_write_struct(&png_, &info_);
  }

  Kind kind_;
  std::string path_;
  Complaint complaint_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

struct Header {
  png_uint_32 width = 0, height = 0;
  int bits = 0, colour = 0;
};

void readHeader(png_structp png, png_infop info, void* context) {
  auto* h = static_cast<Header*>(context);
  png_set_sig_bytes(png, kSignatureSize);
  png_read_info(png, info);
  png_get_IHDR(png, info, &h->width, &h->height, &h->bits, &h->colour, nullptr, nullptr, nullptr);
}

void readRows(png_structp png, png_infop info, void* context) {
  png_set_interlace_handling(png);
  if (png_get_bit_depth(png, info) == 16) png_set_swap(png);
  png_read_update_info(png, info);
  png_read_image(png, static_cast<png_bytepp>(context));
  png_read_end(png, nullptr);
}

void requireSignature(std::FILE* file, const std::string& path) {
  png_byte signature[kSignatureSize];
  const std::size_t count = std::fread(signature, 1, kSignatureSize, file);
  if (count == 0) throw IoError(path, "is empty");
  if (count < kSignatureSize || png_sig_cmp(signature, 0, kSignatureSize))
    throw IoError(path, "is not a PNG file");
}

void requireGrey(const Header& h, int min_bits, const std::string& path) {
  if (h.colour != PNG_COLOR_TYPE_GRAY)
    throw IoError(path,
                  fmt::format("is not a greyscale PNG of {} bits, which alone is read, but one of type {}",
                              min_bits,
                              h.colour == PNG_COLOR_TYPE_PALETTE      ? "palette"
                              : h.colour == PNG_COLOR_TYPE_GRAY_ALPHA ? "grey with alpha"
                                                                      : "colour"));
  if (h.bits < min_bits) throw IoError(path, fmt::format("has {} bits per pixel, not {}", h.bits, min_bits));
}

template <typename T>
std::vector<png_bytep> rowPointers(std::vector<T>& values, std::size_t height) {
  std::vector<png_bytep> rows(height);
  for (std::size_t y = 0; y < height; ++y)
    rows[y] = reinterpret_cast<png_bytep>(values.data() + y * (values.size() / height));
  return rows;
}

/** An image of one or more channels: rows of bytes, 16-bit values in the order of this machine. */
struct EncodedPng {
  Header header;
  std::vector<png_byte> bytes;
};

/** \param channelsOf throws for headers of other images */
template <typename ChannelsOf>
EncodedPng readPng(const files::FilePtr& file, const std::string& name, const ChannelsOf& channelsOf) {
  requireSignature(file.get(), name);
  Codec codec(Codec::Kind::kRead, file.get(), name);
  EncodedPng png;
  codec.run(readHeader, &png.header);
  const Header& h = png.header;
  const auto channels = static_cast<std::size_t>(channelsOf(h));
  requireSize(name, h.width, h.height);
  png.bytes.resize(std::size_t(h.width) * h.height * channels * h.bits / 8);
  codec.run(readRows, rowPointers(png.bytes, h.height).data());
  return png;
}

Raster<std::uint16_t> readGrey(const files::FilePtr& file, const std::string& name, int min_bits) {
  const EncodedPng png = readPng(file, name, [&](const Header& h) {
    requireGrey(h, min_bits, name);
    return 1;
  });
  const std::size_t bytes_per_pixel = png.header.bits / 8;
  Raster<std::uint16_t> image{static_cast<int>(png.header.width), static_cast<int>(png.header.height), 1, {}};
  image.data.resize(png.bytes.size() / bytes_per_pixel);
  if (bytes_per_pixel == 1)
    std::copy(png.bytes.begin(), png.bytes.end(), image.data.begin());
  else
    std::memcpy(image.data.data(), png.bytes.data(), png.bytes.size());
  return image;
}

files::FilePtr inMemory(const std::uint8_t* data, std::size_t size, const std::string& name) {
  if (size == 0) throw IoError(name, "is empty");
  files::FilePtr file(fmemopen(const_cast<std::uint8_t*>(data), size, "rb"));  // which only reads
  if (!file) throw IoError(name, files::lastError());
  return file;
}

/** An image as libpng takes it: rows of bytes, 16-bit values in the order of this machine. */
struct Encoded {
  Header header;
  png_bytepp rows = nullptr;
};

void writeImage(png_structp png, png_infop info, void* context) {
  const auto* image = static_cast<const Encoded*>(context);
  const Header& h = image->header;
  png_set_IHDR(png, info, h.width, h.height, h.bits, h.colour, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, kZlibLevel);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_write_info(png, info);
  if (h.bits == 16) png_set_swap(png);
  png_write_image(png, image->rows);
  png_write_end(png, info);
}

template <typename T>
void write(const fs::path& path, Raster<T> image, bool channels_ok) {
  const bool sized = image.width > 0 && image.height > 0 && channels_ok &&
                     image.data.size() == std::size_t(image.width) * image.height * image.channels;
  if (!sized) throw std::invalid_argument("writePng: the image's size does not match its data");
  const Header header{static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height),
                      8 * int(sizeof(T)), image.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB};
  writeAtomically(path, [&](const fs::path& temporary) {
    const files::FilePtr file(std::fopen(temporary.c_str(), "wb"));
    if (!file) throw WriteError(path.string(), files::lastError());
    auto rows = rowPointers(image.data, header.height);
    Encoded encoded{header, rows.data()};
    Codec(Codec::Kind::kWrite, file.get(), path.string()).run(writeImage, &encoded);
    if (std::fflush(file.get()) != 0) throw WriteError(path.string(), files::lastError());
  });
}

}  // namespace

std::optional<PngSize> pngSize(const fs::path& path) {
  try {
    files::requireFile(path);
    const files::FilePtr file = files::open(path);
    requireSignature(file.get(), path.string());
    Header header;
    Codec(Codec::Kind::kRead, file.get(), path.string()).run(readHeader, &header);
    return PngSize{static_cast<int>(header.width), static_cast<int>(header.height), header.bits};
  } catch (const IoError&) {
    return {};
  }
}

Raster<std::uint16_t> readGreyPng(const fs::path& path, int min_bits) {
  files::requireFile(path);
  return readGrey(files::open(path), path.string(), min_bits);
}

Raster<std::uint16_t> readGreyPng(const std::uint8_t* data, std::size_t size, const std::string& name,
                                  int min_bits) {
  return readGrey(inMemory(data, size, name), name, min_bits);
}

Raster<std::uint8_t> readRgbaPng(const std::uint8_t* data, std::size_t size, const std::string& name) {
  constexpr int kBits = 8, kChannels = 4;
  EncodedPng png = readPng(inMemory(data, size, name), name, [&name](const Header& h) {
    if (h.colour != PNG_COLOR_TYPE_RGB_ALPHA || h.bits != kBits)
      throw IoError(name, "is not a PNG of 8 bits with red, green, blue and alpha");
    return kChannels;
  });
  return {static_cast<int>(png.header.width), static_cast<int>(png.header.height), kChannels,
          std::move(png.bytes)};
}

bool isRgbaPng(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kColour = 25;  // place of the type of colour, in the first chunk
  return size > kColour && png_sig_cmp(data, 0, kSignatureSize) == 0 &&
         data[kColour] == PNG_COLOR_TYPE_RGB_ALPHA;
}

void writePng(const fs::path& path, const Raster<std::uint16_t>& image) {
  write(path, image, image.channels == 1);
}

void writePng(const fs::path& path, const Raster<std::uint8_t>& image) {
  write(path, image, image.channels == 1 || image.channels == 3);
}

}  // namespace facetloc
