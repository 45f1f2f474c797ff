// SPDX-License-Identifier: BSD-3-Clause
#include "images/depth_file.h"

#include "base/median.h"
#include "bytes/files.h"

#include <facetloc/features/depth_image.h>
#include <facetloc/io/pclzf.h>

namespace facetloc {
namespace {

StoredDepth readPng(const fs::path& path) {
  constexpr int kBits = 16;
  return storedIn(readGreyPng(path, kBits));
}

StoredDepth readPacked(const fs::path& path) { return storedIn(readPclzf(path)); }

struct Format {
  const char* ending;
  StoredDepth (*read)(const fs::path& path);
};

constexpr Format kFormats[] = {{".png", readPng},   {".pclzf", readPacked}, {".tif", readTiff},
                               {".tiff", readTiff}, {".npy", readNpy},      {".pgm", readPgm},
                               {".pfm", readPfm}};

const Format* formatOf(const fs::path& path) {
  const std::string extension = internal::lowerExtension(path);
  for (const Format& format : kFormats)
    if (extension == format.ending) return &format;
  return nullptr;
}

/** Unmeasured values become 0, millimetres metres, and depth along the negative z axis, as of
 * renderers, positive. */
void toMetres(std::vector<float>& values) {
  constexpr float kFarthest = 100, kMillimetres = 1000;
  const auto n = [&values](auto holds) { return std::count_if(values.begin(), values.end(), holds); };
  const bool negative = n([](float z) { return isMeasured(-z); }) > n([](float z) { return isMeasured(z); });
  std::vector<float> measured;
  for (float& z : values) {
    if (negative) z = -z;
    if (!isMeasured(z)) z = 0;
    if (z > 0) measured.push_back(z);
  }
  if (measured.empty() || internal::median(std::move(measured)) < kFarthest) return;
  for (float& z : values) z /= kMillimetres;
}

}  // namespace

std::vector<float> metresOf(const std::vector<std::uint16_t>& values, double scale) {
  std::vector<float> metres(values.size());
  std::transform(values.begin(), values.end(), metres.begin(), [scale](std::uint16_t value) {
    return value == kNotMeasured ? 0 : static_cast<float>(value / scale);
  });
  return metres;
}

std::string depthFileEndings() {
  std::string words;
  for (const Format& format : kFormats) words += (words.empty() ? "" : ", ") + std::string(format.ending);
  return words;
}

bool isDepthFile(const fs::path& path) { return formatOf(path) != nullptr; }

StoredDepth readDepthValues(const fs::path& path) {
  const Format* format = formatOf(path);
  if (!format) throw IoError(path.string(), "is no depth image, by its name");
  StoredDepth values = format->read(path);
  toMetres(values.metres);
  return values;
}

std::optional<PngSize> depthFileSize(const fs::path& path) {
  if (internal::isPng(path)) return pngSize(path);
  try {
    const StoredDepth values = readDepthValues(path);
    return PngSize{values.width, values.height, values.metres.empty() ? 16 : 32};
  } catch (const IoError&) {
    return {};
  }
}

}  // namespace facetloc
