// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/segment_file.h>
#include <facetloc/features/segment_frame.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/png.h>

#include <pcl/io/pcd_io.h>

#include <array>
#include <fstream>

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

}  // namespace facetloc
