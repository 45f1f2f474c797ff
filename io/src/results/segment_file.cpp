// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "clouds/point_formats.h"

#include <facetloc/features/segment_frame.h>
#include <facetloc/io/png.h>
#include <facetloc/io/segment_file.h>

#include <pcl/common/io.h>
#include <pcl/conversions.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>

namespace facetloc {
namespace {

/** Copies a field into each frame. PCL's own conversion warns aloud of fields that are not there. */
void readField(const pcl::PCLPointField& field, const pcl::PCLPointCloud2& raw, const std::string& path,
               std::vector<SegmentFrame>& frames) {
  const pcl::PCLPointField* found = fieldOf(raw, field.name);
  if (!found)
    throw IoError(
        path, fmt::format("has no field {}: it is not a file of segments of facetloc_segment", field.name));
  if (found->datatype != field.datatype || found->count != field.count)
    throw IoError(path, fmt::format("has a field {} of another type than segments have", field.name));
  const std::size_t bytes = field.count * static_cast<std::size_t>(pcl::getFieldSize(field.datatype));
  for (std::size_t i = 0; i < frames.size(); ++i)
    std::memcpy(reinterpret_cast<std::uint8_t*>(&frames[i]) + field.offset,
                raw.data.data() + i * raw.point_step + found->offset, bytes);
}

}  // namespace

bool isSegmentFile(const fs::path& path) {
  return internal::endsWith(path.filename().string(), kSegmentEnding);
}

std::vector<Segment> readSegments(const fs::path& path) {
  constexpr std::size_t kMost = 65535;  // labels of an image
  const PcdHeader header(path, true);
  const std::size_t n = std::size_t(header.width) * header.height;
  if (n == 0) return {};
  if (n > kMost) throw IoError(path.string(), "has more segments than an image can have");
  const pcl::PCLPointCloud2 raw = readPcd(path, header);
  std::vector<SegmentFrame> frames(n);
  for (const pcl::PCLPointField& field : pcl::getFields<SegmentFrame>())
    readField(field, raw, path.string(), frames);
  std::vector<Segment> segments(n);
  for (std::size_t i = 0; i < n; ++i)
    if (!toSegment(frames[i], segments[i]))
      throw IoError(path.string(), fmt::format("is corrupt: its point {} is no segment", i));
  return segments;
}

void writeSegments(const fs::path& path, const std::vector<Segment>& segments) {
  pcl::PointCloud<SegmentFrame> cloud = toCloud(segments);
  cloud.height = 1;
  pcl::PCLPointCloud2 fields;
  pcl::toPCLPointCloud2(cloud, fields);
  writePcd(path, fields);
}

void writeLabels(const fs::path& path, const LabelImage& labels) {
  writePng(path, Raster<std::uint16_t>{labels.width, labels.height, 1, labels.label});
}

}  // namespace facetloc
