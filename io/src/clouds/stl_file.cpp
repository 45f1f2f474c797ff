// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "clouds/point_formats.h"

#include <pcl/conversions.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>

namespace facetloc {
namespace {

using Corner = std::array<float, 3>;
constexpr std::size_t kHeader = 84, kTriangle = 50;  // bytes of a binary file

// Programs begin the header of binary files with "solid" as well.
bool isText(std::string_view bytes) {
  constexpr std::size_t kLooked = 1 << 16;
  const std::string_view begin = bytes.substr(0, kLooked);
  return begin.substr(0, 5) == "solid" && std::all_of(begin.begin(), begin.end(), [](char c) {
           return (c >= ' ' && c <= '~') || c == '\t' || c == '\n' || c == '\r';
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
pcl::PolygonMesh readText(const std::filesystem::path& path, std::string_view bytes) {
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

pcl::PolygonMesh readBinary(const std::filesystem::path& path, std::string_view bytes) {
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

}  // namespace

pcl::PolygonMesh readStl(const std::filesystem::path& path) {
  const std::string bytes = files::readBytes(path);
  return isText(bytes) ? readText(path, bytes) : readBinary(path, bytes);
}

}  // namespace facetloc
