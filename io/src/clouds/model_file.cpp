// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "clouds/obj_file.h"
#include "clouds/pcd_points.h"
#include "clouds/ply_file.h"
#include "clouds/stl_file.h"

#include <facetloc/io/error.h>
#include <facetloc/io/model_file.h>

#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

/** A number of each point of a cloud, a float or a double. */
struct PointField {
  /** Nothing if the cloud has no such field. */
  static std::optional<PointField> of(const pcl::PCLPointCloud2& cloud, const std::string& name) {
    for (const pcl::PCLPointField& field : cloud.fields) {
      if (field.name != name) continue;
      const bool is_double = field.datatype == pcl::PCLPointField::FLOAT64;
      if (!is_double && field.datatype != pcl::PCLPointField::FLOAT32) return {};
      if (field.offset + (is_double ? sizeof(double) : sizeof(float)) > cloud.point_step) return {};
      return PointField{field.offset, is_double};
    }
    return {};
  }
  double at(const std::uint8_t* point) const { return is_double ? as<double>(point) : as<float>(point); }

  template <class Number>
  Number as(const std::uint8_t* point) const {
    Number value;
    std::memcpy(&value, point + offset, sizeof value);
    return value;
  }

  std::size_t offset;
  bool is_double;
};

/** Positions in metres. */
pcl::PCLPointCloud2 pointsOf(const pcl::PCLPointCloud2& cloud, double factor, const std::string& path) {
  const std::size_t size = static_cast<std::size_t>(cloud.width) * cloud.height;
  if (size == 0) throw IoError(path, "has no points");
  const auto x = PointField::of(cloud, "x"), y = PointField::of(cloud, "y"), z = PointField::of(cloud, "z");
  if (!x || !y || !z) throw IoError(path, "its points have no x, y and z as floating-point numbers");
  if (cloud.data.size() / cloud.point_step < size) throw IoError(path, "has fewer points than it says");
  pcl::PointCloud<pcl::PointXYZ> points;
  points.reserve(size);
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint8_t* point = cloud.data.data() + i * cloud.point_step;
    const auto coordinate = [&](const PointField& field) {
      return static_cast<float>(factor * field.at(point));
    };
    points.emplace_back(coordinate(*x), coordinate(*y), coordinate(*z));
  }
  pcl::PCLPointCloud2 out;
  pcl::toPCLPointCloud2(points, out);
  return out;
}

pcl::PolygonMesh readAny(const fs::path& path) {
  const std::string kind = internal::lowerExtension(path);
  files::requireRegularFile(path);
  if (fs::file_size(path) == 0) throw IoError(path.string(), "is empty");
  if (kind == ".ply") return readPly(path);
  if (kind == ".obj") return readObj(path);
  if (kind == ".stl") return readStl(path);
  if (kind == ".pgm" || kind == ".png" || kind == ".bmp")
    throw IoError(path.string(),
                  "is an image: of a floor plan, name the .yaml with its image, resolution and origin");
  if (kind != ".pcd")
    throw IoError(path.string(), "is no model that can be read: .ply, .obj, .stl and .pcd can");
  pcl::PolygonMesh cloud;
  cloud.cloud = readPcd(path, PcdHeader(path));
  return cloud;
}

}  // namespace

pcl::PolygonMesh readModel(const fs::path& path, double metres_per_unit) {
  if (!(metres_per_unit > 0 && std::isfinite(metres_per_unit)))
    throw std::invalid_argument("readModel: the unit must be positive");
  pcl::PolygonMesh mesh = readAny(path);
  mesh.cloud = pointsOf(mesh.cloud, metres_per_unit, path.string());
  return mesh;
}

}  // namespace facetloc
