// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "clouds/pcd_points.h"

#include <facetloc/features/segment_frame.h>
#include <facetloc/io/error.h>
#include <facetloc/io/png.h>
#include <facetloc/io/segment_file.h>

#include <pcl/conversions.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>

namespace facetloc {
namespace {

/** \brief A field of SegmentFrame. */
struct Field {
  const char* name;
  std::uint8_t type;
  std::size_t offset, count;
};

constexpr std::size_t kFieldBytes = 4;  // size of a number, of both types
constexpr Field kFields[] = {
    {"x", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, x), 1},
    {"y", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, y), 1},
    {"z", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, z), 1},
    {"normal_x", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, normal_x), 1},
    {"normal_y", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, normal_y), 1},
    {"normal_z", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, normal_z), 1},
    {"orientation", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, orientation), 4},
    {"sigma_q", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, sigma_q), 6},
    {"lambda", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, lambda), 2},
    {"num_points", pcl::PCLPointField::INT32, offsetof(SegmentFrame, num_points), 1},
    {"noise", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, noise), 1},
    {"hull_size", pcl::PCLPointField::INT32, offsetof(SegmentFrame, hull_size), 1},
    {"hull", pcl::PCLPointField::FLOAT32, offsetof(SegmentFrame, hull), 2 * ConvexHull::kMaxVertices},
};

/** Copies a field into each frame. PCL's own conversion warns aloud of fields that are not there. */
void readField(const Field& field, const pcl::PCLPointCloud2& raw, const std::string& path,
               std::vector<SegmentFrame>& frames) {
  const auto found = std::find_if(raw.fields.begin(), raw.fields.end(),
                                  [&field](const pcl::PCLPointField& f) { return f.name == field.name; });
  if (found == raw.fields.end())
    throw IoError(path, std::string("has no field ") + field.name +
                            ": it is not a file of segments of facetloc_segment");
  const std::size_t bytes = field.count * kFieldBytes;
  if (found->datatype != field.type || found->count != field.count || found->offset + bytes > raw.point_step)
    throw IoError(path, fmt::format("has a field {} of another type than segments have", field.name));
  for (std::size_t i = 0; i < frames.size(); ++i)
    std::memcpy(reinterpret_cast<std::uint8_t*>(&frames[i]) + field.offset,
                raw.data.data() + i * raw.point_step + found->offset, bytes);
}

}  // namespace

bool isSegmentFile(const std::filesystem::path& path) {
  return internal::endsWith(path.filename().string(), kSegmentEnding);
}

std::vector<Segment> readSegments(const std::filesystem::path& path) {
  constexpr std::size_t kMost = 65535;  // labels of an image
  const PcdHeader header(path, true);
  const std::size_t n = std::size_t(header.width()) * header.height();
  if (n == 0) return {};
  if (n > kMost) throw IoError(path.string(), "has more segments than an image can have");
  const pcl::PCLPointCloud2 raw = readPcd(path, header);
  std::vector<SegmentFrame> frames(n);
  for (const Field& field : kFields) readField(field, raw, path.string(), frames);
  std::vector<Segment> segments(n);
  for (std::size_t i = 0; i < n; ++i)
    if (!toSegment(frames[i], segments[i]))
      throw IoError(path.string(), fmt::format("is corrupt: its point {} is no segment", i));
  return segments;
}

void writeSegments(const std::filesystem::path& path, const std::vector<Segment>& segments) {
  pcl::PointCloud<SegmentFrame> cloud = toCloud(segments);
  cloud.height = 1;
  pcl::PCLPointCloud2 fields;
  pcl::toPCLPointCloud2(cloud, fields);
  writePcd(path, fields);
}

void writeLabels(const std::filesystem::path& path, const LabelImage& labels) {
  writePng(path, Raster<std::uint16_t>{labels.width, labels.height, 1, labels.label});
}

}  // namespace facetloc
