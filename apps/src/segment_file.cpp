// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/segment_file.h>
#include <facetloc/features/segment_frame.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>

namespace facetloc {
namespace {

/** PCL writes such a file as well, but complains about it on the console. */
void writeEmptyCloud(const std::filesystem::path& path) {
  pcl::PointCloud<SegmentFrame> none;
  none.height = 1;
  constexpr std::array<char, 8> kNoData = {};  // compressed and uncompressed size
  std::ofstream out(path, std::ios::binary);
  out << pcl::PCDWriter::generateHeader(none, 0) << "DATA binary_compressed\n";
  out.write(kNoData.data(), kNoData.size());
  out.close();
  if (!out) throw IoError(path.string(), "cannot be written");
}

struct DepthRange {
  float nearest = std::numeric_limits<float>::max();
  float farthest = 0;
};

DepthRange rangeOf(const DepthImage& image) {
  DepthRange range;
  for (const float z : image.depth) {
    if (!(z > 0)) continue;
    range.nearest = std::min(range.nearest, z);
    range.farthest = std::max(range.farthest, z);
  }
  return range;
}

/** True at the outline of a segment; holes of one pixel are no outline. */
bool isBorder(const LabelImage& labels, int u, int v) {
  const auto at = [&](int x, int y) -> int {
    if (x < 0 || y < 0 || x >= labels.width || y >= labels.height) return -1;
    return labels.label[static_cast<std::size_t>(y) * labels.width + x];
  };
  const int label = at(u, v);
  const auto endsTowards = [&](int du, int dv) {
    return at(u + du, v + dv) != label && at(u + 2 * du, v + 2 * dv) != label;
  };
  return label > 0 && (endsTowards(1, 0) || endsTowards(0, 1) || endsTowards(-1, 0) || endsTowards(0, -1));
}

}  // namespace

void writeSegments(const std::filesystem::path& path, const std::vector<Segment>& segments) {
  const pcl::PointCloud<SegmentFrame> cloud = toCloud(segments);
  writeAtomically(path, [&](const std::filesystem::path& temporary) {
    if (cloud.empty()) return writeEmptyCloud(temporary);
    if (pcl::PCDWriter().writeBinaryCompressed(temporary.string(), cloud) < 0)
      throw IoError(path.string(), "cannot be written");
  });
}

void writeLabels(const std::filesystem::path& path, const LabelImage& labels) {
  writePng(path, Raster<std::uint16_t>{labels.width, labels.height, 1, labels.label});
}

Raster<std::uint8_t> overlay(const DepthImage& image, const LabelImage& labels) {
  constexpr float kDarkest = 50, kBrightest = 255;  // black is kept for what was not measured
  constexpr std::array<std::uint8_t, 3> kGreen = {0, 220, 0};
  const DepthRange range = rangeOf(image);
  const float scale = (kBrightest - kDarkest) / std::max(range.farthest - range.nearest, 1e-6f);
  Raster<std::uint8_t> out{image.camera.width, image.camera.height, 3, {}};
  out.data.reserve(3 * image.depth.size());
  for (int v = 0; v < out.height; ++v)
    for (int u = 0; u < out.width; ++u) {
      const float z = image.at(u, v);
      const auto grey = static_cast<std::uint8_t>(z > 0 ? kDarkest + scale * (z - range.nearest) : 0);
      if (isBorder(labels, u, v))
        out.data.insert(out.data.end(), kGreen.begin(), kGreen.end());
      else
        out.data.insert(out.data.end(), 3, grey);
    }
  return out;
}

}  // namespace facetloc
