// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/ply_file.h"

#include "base/text.h"
#include "bytes/files.h"
#include "bytes/word_reader.h"
#include "clouds/ply_header.h"

#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <string>

namespace facetloc {
namespace {

template <class Number>
double asDouble(const char* bytes) {
  Number number;
  std::memcpy(&number, bytes, sizeof number);
  return static_cast<double>(number);
}

double decoded(PlyNumber type, const char* bytes) {
  switch (type) {
  case PlyNumber::int8:
    return asDouble<std::int8_t>(bytes);
  case PlyNumber::uint8:
    return asDouble<std::uint8_t>(bytes);
  case PlyNumber::int16:
    return asDouble<std::int16_t>(bytes);
  case PlyNumber::uint16:
    return asDouble<std::uint16_t>(bytes);
  case PlyNumber::int32:
    return asDouble<std::int32_t>(bytes);
  case PlyNumber::uint32:
    return asDouble<std::uint32_t>(bytes);
  case PlyNumber::float32:
    return asDouble<float>(bytes);
  default:
    return asDouble<double>(bytes);
  }
}

/** The numbers behind a header, one after the other. All of them are exact as doubles. */
class PlyNumbers {
public:
  PlyNumbers(std::string_view rest, PlyHeader::Encoding encoding, const std::string& path)
      : rest_(rest), encoding_(encoding), path_(path) {}

  double next(PlyNumber type) { return encoding_ == PlyHeader::Encoding::text ? word() : binary(type); }
  /** Throws IoError unless that number of values may follow. */
  void requireRoomFor(std::size_t n, PlyNumber type) const {
    if (n > rest_.size() / (encoding_ == PlyHeader::Encoding::text ? 1 : sizeOf(type))) failCutOff();
  }

private:
  [[noreturn]] void failCutOff() const {
    throw IoError(path_, "is cut off: its data end before all that its header promises");
  }
  double word() {
    WordReader words(rest_);
    const std::string_view word = words.next();
    if (word.empty()) failCutOff();
    rest_ = words.rest();
    const auto number = text::to<double>(word);
    if (!number) throw IoError(path_, fmt::format("has '{}' where its header promises a number", word));
    return *number;
  }
  double binary(PlyNumber type) {
    const std::size_t size = sizeOf(type);
    if (rest_.size() < size) failCutOff();
    std::array<char, sizeof(double)> bytes{};
    std::copy_n(rest_.begin(), size, bytes.begin());
    if (encoding_ == PlyHeader::Encoding::big_endian)
      std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    rest_.remove_prefix(size);
    return decoded(type, bytes.data());
  }

  std::string_view rest_;
  PlyHeader::Encoding encoding_;
  const std::string& path_;
};

class PlyReader {
public:
  explicit PlyReader(const std::string& path) : path_(path) {}

  void read(const PlyElement& element, PlyNumbers& numbers) {
    if (element.properties.empty()) return;
    for (std::size_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties)
        property.is_list ? readList(element, property, numbers) : readNumber(element, property, numbers);
      if (element.name == "vertex") positions_.insert(positions_.end(), position_.begin(), position_.end());
    }
    if (element.name == "vertex")
      has_positions_ = std::all_of(kAxes.begin(), kAxes.end(), [&](const char* axis) {
        return std::any_of(element.properties.begin(), element.properties.end(),
                           [&](const PlyProperty& p) { return p.name == axis && !p.is_list; });
      });
  }

  pcl::PolygonMesh mesh() {
    if (!has_positions_) throw IoError(path_, "its points have no x, y and z");
    pcl::PolygonMesh mesh;
    constexpr std::uint32_t kStep = 3 * sizeof(double);
    for (std::uint32_t k = 0; k < 3; ++k) {
      pcl::PCLPointField field;
      field.name = kAxes[k];
      field.offset = k * static_cast<std::uint32_t>(sizeof(double));
      field.datatype = pcl::PCLPointField::FLOAT64;
      field.count = 1;
      mesh.cloud.fields.push_back(field);
    }
    mesh.cloud.height = 1;
    mesh.cloud.width = static_cast<std::uint32_t>(positions_.size() / 3);
    mesh.cloud.point_step = kStep;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(positions_.data());
    mesh.cloud.data.assign(bytes, bytes + positions_.size() * sizeof(double));
    mesh.polygons = std::move(faces_);
    return mesh;
  }

private:
  static constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};

  void readNumber(const PlyElement& element, const PlyProperty& property, PlyNumbers& numbers) {
    const double number = numbers.next(property.type);
    for (std::size_t k = 0; k < 3; ++k)
      if (element.name == "vertex" && property.name == kAxes[k]) position_[k] = number;
  }
  void readList(const PlyElement& element, const PlyProperty& property, PlyNumbers& numbers) {
    const double length = numbers.next(property.length);
    if (!(length >= 0 && length <= std::numeric_limits<std::uint32_t>::max()))
      throw IoError(path_, fmt::format("has {} as the length of a list", length));
    const auto n = static_cast<std::size_t>(length);
    numbers.requireRoomFor(n, property.type);
    const bool is_face =
        element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
    if (is_face) faces_.emplace_back();
    for (std::size_t i = 0; i < n; ++i) {
      const double number = numbers.next(property.type);
      if (is_face) faces_.back().vertices.push_back(indexOf(number));
    }
  }
  pcl::index_t indexOf(double number) const {
    using Limits = std::numeric_limits<pcl::index_t>;
    if (!(number >= Limits::min() && number <= Limits::max()))
      throw IoError(path_, fmt::format("has {} as a vertex of a face", number));
    return static_cast<pcl::index_t>(number);
  }

  const std::string& path_;
  std::array<double, 3> position_{};
  std::vector<double> positions_;
  bool has_positions_ = false;
  std::vector<pcl::Vertices> faces_;
};

template <class Number>
void put(std::string& out, Number number) {
  out.append(reinterpret_cast<const char*>(&number), sizeof number);
}

bool hasColours(const pcl::PCLPointCloud2& cloud) {
  return std::any_of(cloud.fields.begin(), cloud.fields.end(),
                     [](const pcl::PCLPointField& field) { return field.name == "rgb"; });
}

template <class PointT>
std::string vertices(const pcl::PCLPointCloud2& cloud) {
  pcl::PointCloud<PointT> points;
  pcl::fromPCLPointCloud2(cloud, points);
  std::string out;
  for (const PointT& p : points) {
    for (const float number : {p.x, p.y, p.z}) put(out, number);
    if constexpr (std::is_same_v<PointT, pcl::PointXYZRGB>)
      for (const std::uint8_t part : {p.r, p.g, p.b}) put(out, part);
  }
  return out;
}

/** As few bytes as all lengths need: many programs know lists of up to 255 alone. */
template <class Length>
std::string faces(const std::vector<pcl::Vertices>& polygons) {
  std::string out;
  for (const pcl::Vertices& polygon : polygons) {
    put(out, static_cast<Length>(polygon.vertices.size()));
    for (const pcl::index_t vertex : polygon.vertices) put(out, static_cast<std::int32_t>(vertex));
  }
  return out;
}

}  // namespace

pcl::PolygonMesh readPly(const std::filesystem::path& path) {
  files::requireRegularFile(path);
  const std::string bytes = files::readBytes(path), name = path.string();
  const PlyHeader header(bytes, name);
  PlyNumbers numbers(std::string_view(bytes).substr(header.end), header.encoding, name);
  PlyReader reader(name);
  for (const PlyElement& element : header.elements) reader.read(element, numbers);
  return reader.mesh();
}

void writePly(std::ostream& out, const pcl::PolygonMesh& mesh) {
  const bool coloured = hasColours(mesh.cloud);
  const bool long_faces =
      std::any_of(mesh.polygons.begin(), mesh.polygons.end(), [](const pcl::Vertices& polygon) {
        return polygon.vertices.size() > std::numeric_limits<std::uint8_t>::max();
      });
  out << fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\n{}element face {}\nproperty list {} int vertex_indices\nend_header\n",
      std::size_t(mesh.cloud.width) * mesh.cloud.height,
      coloured ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "", mesh.polygons.size(),
      long_faces ? "uint" : "uchar");
  out << (coloured ? vertices<pcl::PointXYZRGB>(mesh.cloud) : vertices<pcl::PointXYZ>(mesh.cloud));
  out << (long_faces ? faces<std::uint32_t>(mesh.polygons) : faces<std::uint8_t>(mesh.polygons));
}

}  // namespace facetloc
