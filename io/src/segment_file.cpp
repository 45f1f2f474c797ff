// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/segment_frame.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/png.h>
#include <facetloc/io/segment_file.h>

#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>

#include <array>
#include <sstream>

namespace facetloc {
namespace {

/** PCL writes such a file as well, but complains about it on the console. */
void writeEmptyCloud(std::ostream& out) {
  pcl::PointCloud<SegmentFrame> none;
  none.height = 1;
  constexpr std::array<char, 8> kNoData = {};  // compressed and uncompressed size
  out << pcl::PCDWriter::generateHeader(none, 0) << "DATA binary_compressed\n";
  out.write(kNoData.data(), kNoData.size());
}

}  // namespace

void writeSegments(const std::filesystem::path& path, const std::vector<Segment>& segments) {
  const pcl::PointCloud<SegmentFrame> cloud = toCloud(segments);
  std::ostringstream bytes;  // where PCL writes a file itself, it does not tell why it cannot
  if (cloud.empty()) {
    writeEmptyCloud(bytes);
  } else {
    pcl::PCLPointCloud2 fields;
    pcl::toPCLPointCloud2(cloud, fields);
    if (pcl::PCDWriter().writeBinaryCompressed(bytes, fields) != 0)
      throw IoError(path.string(), "cannot be written: PCL cannot compress it");
  }
  writeTextAtomically(path, [&](std::ostream& out) { out << bytes.str(); });
}

void writeLabels(const std::filesystem::path& path, const LabelImage& labels) {
  writePng(path, Raster<std::uint16_t>{labels.width, labels.height, 1, labels.label});
}

}  // namespace facetloc
