// SPDX-License-Identifier: BSD-3-Clause
// PCL's own reader writes beyond its memory if there are more normals than vertices.
#include "base/text.h"
#include "bytes/files.h"
#include "clouds/point_formats.h"

#include <pcl/conversions.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <fmt/format.h>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace facetloc {
namespace {

class ObjReader {
public:
  explicit ObjReader(std::string path) : path_(std::move(path)) {}

  void take(std::string_view line) {
    const std::vector<std::string_view> words = text::words(text::withoutComment(line));
    if (words.empty()) return;
    if (words[0] == "v") addVertex(words);
    if (words[0] == "f") addFace(words);
  }
  void countLine() { ++line_; }

  pcl::PolygonMesh mesh() {
    pcl::PolygonMesh mesh;
    pcl::toPCLPointCloud2(points_, mesh.cloud);
    mesh.polygons = std::move(faces_);
    return mesh;
  }

private:
  [[noreturn]] void fail(const std::string& cause) const {
    throw IoError(path_, fmt::format("line {}: {}", line_, cause));
  }

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

  const std::string path_;
  std::size_t line_ = 1;
  pcl::PointCloud<pcl::PointXYZ> points_;
  std::vector<pcl::Vertices> faces_;
};

}  // namespace

pcl::PolygonMesh readObj(const std::filesystem::path& path) {
  std::istringstream in(files::readText(path));
  ObjReader reader(path.string());
  std::string line, whole;
  while (std::getline(in, line)) {
    const std::string_view part = text::trimmed(line);
    const bool goes_on = !part.empty() && part.back() == '\\';
    whole += part.substr(0, part.size() - goes_on);
    whole += ' ';
    if (!goes_on) {
      reader.take(whole);
      whole.clear();
    }
    reader.countLine();
  }
  reader.take(whole);
  return reader.mesh();
}

}  // namespace facetloc
