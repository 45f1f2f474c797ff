// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "clouds/point_formats.h"

#include <facetloc/io/cloud_file.h>
#include <facetloc/io/error.h>

#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

/** Positions in metres. */
pcl::PCLPointCloud2 pointsOf(const pcl::PCLPointCloud2& cloud, double factor, const std::string& path) {
  const std::size_t size = static_cast<std::size_t>(cloud.width) * cloud.height;
  if (size == 0) throw IoError(path, "has no points");
  const auto *x = fieldOf(cloud, "x"), *y = fieldOf(cloud, "y"), *z = fieldOf(cloud, "z");
  for (const auto* field : {x, y, z})
    if (!field || !isFloatingPoint(*field))
      throw IoError(path, "its points have no x, y and z as floating-point numbers");
  if (cloud.data.size() / cloud.point_step < size) throw IoError(path, "has fewer points than it says");
  pcl::PointCloud<pcl::PointXYZ> points;
  points.reserve(size);
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint8_t* point = cloud.data.data() + i * cloud.point_step;
    const auto coordinate = [&](const pcl::PCLPointField& field) {
      return static_cast<float>(factor * numberAt(field.datatype, point + field.offset));
    };
    points.emplace_back(coordinate(*x), coordinate(*y), coordinate(*z));
  }
  pcl::PCLPointCloud2 out;
  pcl::toPCLPointCloud2(points, out);
  return out;
}

/** The .yaml beside the image of a plan, or the lines to write into one. */
std::string adviceOnPlan(const fs::path& image) {
  const fs::path yaml = fs::path(image).replace_extension(".yaml");
  std::error_code ignored;
  if (fs::exists(yaml, ignored))
    return fmt::format("is an image: of a floor plan, name its {}", yaml.filename().string());
  return fmt::format(
      "is an image: a floor plan is named by its .yaml file, so write {} with these lines, the second and "
      "third in metres\n  image: {}\n  resolution: 0.05    # side of a pixel\n  origin: [0, 0, 0]   # lower "
      "left corner, yaw\n  negate: 0\n  occupied_thresh: 0.65\n  free_thresh: 0.196",
      yaml.string(), image.filename().string());
}

pcl::PolygonMesh readAny(const fs::path& path) {
  const std::string kind = internal::lowerExtension(path);
  files::requireRegularFile(path);
  if (fs::file_size(path) == 0) throw IoError(path.string(), "is empty");
  if (kind == ".ply") return readPly(path);
  if (kind == ".obj") return readObj(path);
  if (kind == ".stl") return readStl(path);
  if (kind == ".pgm" || kind == ".png" || kind == ".bmp") throw IoError(path.string(), adviceOnPlan(path));
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
