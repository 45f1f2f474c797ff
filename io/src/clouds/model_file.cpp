// SPDX-License-Identifier: BSD-3-Clause
// PCL's own reader of OBJ writes beyond its memory if there are more normals than vertices.
#include "bytes/files.h"
#include "clouds/point_formats.h"

#include <facetloc/io/cloud_file.h>

#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

class ObjReader {
public:
  void take(std::string_view line) {
    const std::vector<std::string_view> words = text::words(text::withoutComment(line));
    if (words.empty()) return;
    if (words[0] == "v") addVertex(words);
    if (words[0] == "f") addFace(words);
  }

  pcl::PolygonMesh mesh() {
    pcl::PolygonMesh mesh;
    pcl::toPCLPointCloud2(points_, mesh.cloud);
    mesh.polygons = std::move(faces_);
    return mesh;
  }

private:
  [[noreturn]] static void fail(const std::string& cause) { throw std::invalid_argument(cause); }

  /** v x y z, behind which may be a weight or a colour. */
  void addVertex(const std::vector<std::string_view>& words) {
    constexpr std::size_t kMost = std::numeric_limits<pcl::index_t>::max();
    if (words.size() < 4) fail("has a vertex of fewer than three coordinates");
    if (points_.size() >= kMost) fail("has more vertices than can be read");
    float xyz[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto number = text::to<double>(words[k + 1]);
      if (!number) fail(fmt::format("has '{}' as a coordinate", words[k + 1]));
      xyz[k] = static_cast<float>(*number);
    }
    points_.emplace_back(xyz[0], xyz[1], xyz[2]);
  }

  /** f vertex/texture/normal ... of at least three corners. */
  void addFace(const std::vector<std::string_view>& words) {
    if (words.size() < 4) fail("has a face of fewer than three corners");
    pcl::Vertices face;
    for (std::size_t k = 1; k < words.size(); ++k)
      face.vertices.push_back(vertexOf(words[k].substr(0, words[k].find('/'))));
    faces_.push_back(std::move(face));
  }

  /** Vertices count from 1, or back from the latest one, which is -1. */
  pcl::index_t vertexOf(std::string_view word) const {
    const auto number = text::to<pcl::index_t>(word);
    if (!number || *number == 0) fail(fmt::format("has '{}' as a vertex of a face", word));
    if (*number > 0) return *number - 1;
    return static_cast<pcl::index_t>(points_.size()) + *number;
  }

  pcl::PointCloud<pcl::PointXYZ> points_;
  std::vector<pcl::Vertices> faces_;
};

using Corner = std::array<float, 3>;
constexpr std::size_t kHeader = 84, kTriangle = 50;  // bytes of a binary file

// Programs begin the header of binary files with "solid" as well. Names have letters beyond ASCII.
bool isStlText(std::string_view bytes) {
  constexpr std::size_t kLooked = 1 << 16;
  const std::string_view begin = bytes.substr(0, kLooked);
  return text::lower(std::string(begin.substr(0, 5))) == "solid" &&
         std::all_of(begin.begin(), begin.end(), [](unsigned char c) {
           return (c >= ' ' && c != 0x7F) || c == '\t' || c == '\n' || c == '\r';
         });
}

class Triangles {
public:
  void add(const std::array<Corner, 3>& corners) {
    pcl::Vertices& triangle = mesh_.polygons.emplace_back();
    for (const Corner& c : corners) {
      const auto [known, is_new] = indices_.emplace(c, static_cast<pcl::index_t>(points_.size()));
      if (is_new) points_.emplace_back(c[0], c[1], c[2]);
      triangle.vertices.push_back(known->second);
    }
  }
  std::size_t size() const { return mesh_.polygons.size(); }
  pcl::PolygonMesh mesh() {
    pcl::toPCLPointCloud2(points_, mesh_.cloud);
    return std::move(mesh_);
  }

private:
  struct ByBytes {  // also of numbers that are not ordered
    bool operator()(const Corner& a, const Corner& b) const { return std::memcmp(&a, &b, sizeof a) < 0; }
  };
  std::map<Corner, pcl::index_t, ByBytes> indices_;
  pcl::PointCloud<pcl::PointXYZ> points_;
  pcl::PolygonMesh mesh_;
};

// "vertex x y z" thrice for each triangle; all other words repeat it.
pcl::PolygonMesh readStlText(const fs::path& path, std::string_view bytes) {
  Triangles triangles;
  std::array<Corner, 3> corners;
  std::size_t known = 0;
  WordReader words(bytes);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (text::lower(std::string(word)) != "vertex") continue;
    for (float& coordinate : corners[known]) {
      const std::string_view number = words.next();
      const auto value = text::to<double>(number);
      if (!value)
        throw IoError(path.string(),
                      fmt::format("has '{}' as a coordinate of triangle {}", number, triangles.size() + 1));
      coordinate = static_cast<float>(*value);
    }
    if (++known < corners.size()) continue;
    triangles.add(corners);
    known = 0;
  }
  if (known != 0) throw IoError(path.string(), "ends within a triangle");
  return triangles.mesh();
}

pcl::PolygonMesh readStlBinary(const fs::path& path, std::string_view bytes) {
  std::uint32_t size = 0;
  if (bytes.size() >= kHeader) std::memcpy(&size, bytes.data() + kHeader - sizeof size, sizeof size);
  if (bytes.size() < kHeader || bytes.size() - kHeader < kTriangle * size)
    throw IoError(path.string(), "is neither a text nor a whole binary STL file");
  Triangles triangles;
  for (std::size_t i = 0; i < size; ++i) {
    std::array<Corner, 3> corners;  // behind the normal
    std::memcpy(&corners, bytes.data() + kHeader + i * kTriangle + sizeof(Corner), sizeof corners);
    triangles.add(corners);
  }
  return triangles.mesh();
}

/** The vertices and faces of a Wavefront OBJ file, without its normals, textures and materials. Faces may
 * have vertices that are not there. */
pcl::PolygonMesh readObj(const fs::path& path) {
  ObjReader reader;
  std::string whole;  // line with those that go on
  const std::string content = files::readText(path) + "\n";
  files::forEachLine(content, path.string(), [&](std::string_view line) {
    const std::string_view part = text::trimmed(line);
    const bool goes_on = !part.empty() && part.back() == '\\';
    whole.append(part.substr(0, part.size() - goes_on)).append(" ");
    if (!goes_on) reader.take(std::exchange(whole, {}));
  });
  return reader.mesh();
}

/** An .stl file, text or binary. Corners at the same position are one point. */
pcl::PolygonMesh readStl(const fs::path& path) {
  const std::string bytes = files::asUtf8(files::readBytes(path));
  return isStlText(bytes) ? readStlText(path, bytes) : readStlBinary(path, bytes);
}

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
  if (files::isThere(yaml))
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
