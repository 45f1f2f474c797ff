// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/point_formats.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/cloud_file.h>

#include <pcl/common/io.h>
#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <utility>

namespace facetloc {
namespace {

constexpr PointColour kUnlabelled = {150, 150, 150};

PointColour colourOf(std::size_t label, const std::vector<PointColour>& colours) {
  return label > 0 && label <= colours.size() ? colours[label - 1] : kUnlabelled;
}

bool hasFinitePoint(const pcl::PCLPointCloud2& cloud, std::size_t index) {
  return std::all_of(cloud.fields.begin(), cloud.fields.end(), [&](const pcl::PCLPointField& field) {
    return (field.name != "x" && field.name != "y" && field.name != "z") ||
           std::isfinite(
               numberAt(field.datatype, cloud.data.data() + index * cloud.point_step + field.offset));
  });
}

/** Appends a field of one number of 32 bits. \return where it begins in a point */
std::uint32_t addField(const char* name, std::uint8_t type, pcl::PCLPointCloud2& cloud) {
  pcl::PCLPointField field;
  field.name = name, field.count = 1, field.offset = cloud.point_step;
  field.datatype = type;
  cloud.fields.push_back(field);
  cloud.point_step += sizeof(std::uint32_t);
  return field.offset;
}

template <class PointT>
void setColour(const PointColour& colour, PointT& p) {
  p.r = colour.red, p.g = colour.green, p.b = colour.blue;
}

template <class PointT>
pcl::PointCloud<PointT> pointsOf(const DepthImage& image, const Eigen::Isometry3d& T) {
  constexpr float kNotMeasured = std::numeric_limits<float>::quiet_NaN();
  pcl::PointCloud<PointT> cloud(static_cast<std::uint32_t>(image.camera.width),
                                static_cast<std::uint32_t>(image.camera.height));
  cloud.is_dense = false;
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      PointT& p = cloud(static_cast<std::size_t>(u), static_cast<std::size_t>(v));
      const float z = image.at(u, v);
      if (z > 0)
        p.getVector3fMap() = (T * Eigen::Vector3d(image.camera.ray(u, v) * z)).template cast<float>();
      else
        p.x = p.y = p.z = kNotMeasured;
    }
  return cloud;
}

}  // namespace

std::vector<PointColour> readColours(const std::filesystem::path& path, const DepthImage& image) {
  const PcdHeader header(path);
  if (header.width != image.camera.width || header.height != image.camera.height) return {};
  const pcl::PCLPointCloud2 raw = readPcd(path, header);
  using Field = pcl::PCLPointField;
  const auto fieldOfType = [&raw](const char* name, std::initializer_list<int> types) {
    const Field* field = fieldOf(raw, name);
    return field && std::count(types.begin(), types.end(), field->datatype) > 0 ? field : nullptr;
  };
  const Field *packed = fieldOfType("rgb", {Field::FLOAT32, Field::UINT32}),
              *z = fieldOfType("z", {Field::FLOAT32});
  if (!packed) packed = fieldOfType("rgba", {Field::UINT32});
  if (!packed || !z) return {};
  std::vector<PointColour> colours;
  std::size_t same = 0, measured = 0;
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    const std::uint8_t* point = raw.data.data() + i * raw.point_step;
    std::uint32_t value;
    float depth;
    std::memcpy(&value, point + packed->offset, sizeof value);
    std::memcpy(&depth, point + z->offset, sizeof depth);
    colours.push_back({static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
                       static_cast<std::uint8_t>(value)});
    measured += image.depth[i] > 0;
    same += image.depth[i] > 0 && depth == image.depth[i];
  }
  if (2 * same < measured) colours.clear();
  return colours;
}

void writeCloud(const std::filesystem::path& path, const DepthImage& image, const Eigen::Isometry3d& T,
                const std::vector<PointColour>& colours) {
  pcl::PCLPointCloud2 fields;
  if (colours.empty()) {
    pcl::toPCLPointCloud2(pointsOf<pcl::PointXYZ>(image, T), fields);
  } else {
    if (colours.size() != image.depth.size()) throw std::invalid_argument("colours and image differ in size");
    auto cloud = pointsOf<pcl::PointXYZRGB>(image, T);
    for (std::size_t i = 0; i < cloud.size(); ++i) setColour(colours[i], cloud[i]);
    pcl::toPCLPointCloud2(cloud, fields);
  }
  writePcd(path, fields);
}

void writeLabelledCloud(const std::filesystem::path& path, const DepthImage& image, const LabelImage& labels,
                        const std::vector<PointColour>& colours) {
  if (labels.label.size() != image.depth.size())
    throw std::invalid_argument("labels and image differ in size");
  auto cloud = pointsOf<pcl::PointXYZRGBL>(image, Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::size_t label = labels.label[i];
    cloud[i].label = static_cast<std::uint32_t>(label);
    setColour(colourOf(label, colours), cloud[i]);
  }
  pcl::PCLPointCloud2 fields;
  pcl::toPCLPointCloud2(cloud, fields);
  writePcd(path, fields);
}

void writeLabelledCloud(const std::filesystem::path& path, const std::filesystem::path& points,
                        const std::vector<std::uint32_t>& pixels, const LabelImage& labels,
                        const std::vector<PointColour>& colours) {
  const PcdHeader header(points);
  const pcl::PCLPointCloud2 in = readPcd(points, header);
  if (pixels.size() != header.points) throw std::invalid_argument("pixels and points differ in number");
  pcl::PCLPointCloud2 out;
  out.width = in.width, out.height = in.height;
  std::vector<pcl::PCLPointField> kept;
  for (const pcl::PCLPointField& field : in.fields) {
    if (field.name == "label" || field.name == "_") continue;  // "_" is padding
    kept.push_back(field);
    out.fields.push_back(field);
    out.fields.back().offset = out.point_step;
    out.point_step += field.count * static_cast<std::uint32_t>(pcl::getFieldSize(field.datatype));
  }
  const bool is_coloured = fieldOf(in, "rgb") || fieldOf(in, "rgba");
  const std::uint32_t colour_at = is_coloured ? 0 : addField("rgb", pcl::PCLPointField::FLOAT32, out),
                      label_at = addField("label", pcl::PCLPointField::UINT32, out);
  out.data.resize(header.points * out.point_step);
  for (std::size_t i = 0; i < header.points; ++i) {
    std::uint8_t* point = out.data.data() + i * out.point_step;
    for (std::size_t k = 0; k < kept.size(); ++k)
      std::memcpy(point + out.fields[k].offset, in.data.data() + i * in.point_step + kept[k].offset,
                  kept[k].count * static_cast<std::size_t>(pcl::getFieldSize(kept[k].datatype)));
    const bool is_labelled = pixels[i] < labels.label.size() && hasFinitePoint(in, i);
    const std::uint32_t label = is_labelled ? labels.label[pixels[i]] : 0;
    std::memcpy(point + label_at, &label, sizeof label);
    if (is_coloured) continue;
    const PointColour colour = colourOf(label, colours);
    const std::uint32_t rgb = static_cast<std::uint32_t>(colour.red) << 16 |
                              static_cast<std::uint32_t>(colour.green) << 8 | colour.blue;
    std::memcpy(point + colour_at, &rgb, sizeof rgb);
  }
  writePcd(path, out, header.viewpoint);
}

ColouredPolygon polygonOf(const Segment& segment, const PointColour& colour) {
  ColouredPolygon polygon{{}, colour};
  for (const Eigen::Vector2f& vertex : segment.hull)
    polygon.vertices.push_back(segment.t + segment.R.leftCols<2>() * vertex.cast<double>());
  return polygon;
}

void writePolygons(const std::filesystem::path& path, const std::vector<ColouredPolygon>& polygons) {
  pcl::PolygonMesh mesh;
  pcl::PointCloud<pcl::PointXYZRGB> vertices;
  for (const ColouredPolygon& polygon : polygons) {
    if (polygon.vertices.size() < 3) continue;
    pcl::Vertices face;
    for (const Eigen::Vector3d& vertex : polygon.vertices) {
      face.vertices.push_back(static_cast<pcl::index_t>(vertices.size()));
      pcl::PointXYZRGB p;
      p.getVector3fMap() = vertex.cast<float>();
      setColour(polygon.colour, p);
      vertices.push_back(p);
    }
    mesh.polygons.push_back(std::move(face));
  }
  pcl::toPCLPointCloud2(vertices, mesh.cloud);
  writeMesh(path, mesh);
}

void writeMesh(const std::filesystem::path& path, const pcl::PolygonMesh& mesh) {
  writeTextAtomically(path, [&mesh](std::ostream& out) { writePly(out, mesh); });
}

}  // namespace facetloc
