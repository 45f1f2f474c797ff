// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "clouds/point_formats.h"

#include <pcl/common/io.h>
#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <optional>
#include <string>

namespace facetloc {
namespace {

using Field = pcl::PCLPointField;  // whose types of numbers serve

std::size_t sizeOf(std::uint8_t type) { return static_cast<std::size_t>(pcl::getFieldSize(type)); }

/** A number of each element, or a list of numbers. */
struct PlyProperty {
  std::string name;
  std::uint8_t type;
  bool is_list = false;
  std::uint8_t length = Field::UINT8;  ///< type of a list's length
};
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  enum class Encoding { text, little_endian, big_endian };
  Encoding encoding = Encoding::text;
  std::vector<PlyElement> elements;
  std::size_t end = 0;  ///< first byte behind the header
};

struct Type {
  std::string_view name, other_name;
  std::uint8_t type;
};
constexpr Type kTypes[] = {{"char", "int8", Field::INT8},        {"uchar", "uint8", Field::UINT8},
                           {"short", "int16", Field::INT16},     {"ushort", "uint16", Field::UINT16},
                           {"int", "int32", Field::INT32},       {"uint", "uint32", Field::UINT32},
                           {"float", "float32", Field::FLOAT32}, {"double", "float64", Field::FLOAT64}};

std::optional<std::uint8_t> typeNamed(std::string_view name) {
  const auto* type = std::find_if(std::begin(kTypes), std::end(kTypes),
                                  [&](const Type& t) { return name == t.name || name == t.other_name; });
  return type == std::end(kTypes) ? std::nullopt : std::optional(type->type);
}

PlyHeader::Encoding encodingNamed(std::string_view name, const std::string& path) {
  if (name == "ascii") return PlyHeader::Encoding::text;
  if (name == "binary_little_endian") return PlyHeader::Encoding::little_endian;
  if (name == "binary_big_endian") return PlyHeader::Encoding::big_endian;
  throw IoError(path, fmt::format("has '{}' as its format, which PLY does not know", name));
}

PlyElement elementOf(std::string_view name, std::string_view count, const std::string& path) {
  constexpr std::size_t kMost = std::size_t(1) << 31;  // pcl::PCLPointCloud2 counts in 32 bits
  const auto number = text::to<std::size_t>(count);
  if (!number || *number >= kMost)
    throw IoError(path, fmt::format("has '{}' as a number of elements in its header", count));
  return {std::string(name), *number, {}};
}

PlyProperty propertyOf(const std::vector<std::string_view>& words, const std::string& path) {
  const bool is_list = words[1] == "list";
  const std::size_t size = is_list ? 5 : 3;
  const auto type = words.size() == size ? typeNamed(words[size - 2]) : std::nullopt;
  const auto length = is_list ? typeNamed(words[2]) : std::optional<std::uint8_t>(Field::UINT8);
  if (!type || !length)
    throw IoError(path, fmt::format("has a property in its header whose type PLY does not know: {}",
                                    fmt::join(words, " ")));
  return {std::string(words.back()), *type, is_list, *length};
}

/** \return false after the last line. */
bool take(std::string_view line, const std::string& path, PlyHeader& header) {
  const std::string folded = text::lower(std::string(line));
  const std::vector<std::string_view> words = text::words(folded);
  if (words.empty() || words[0] == "comment" || words[0] == "obj_info") return true;
  if (words[0] == "end_header") return false;
  if (words[0] == "format" && words.size() == 3)
    header.encoding = encodingNamed(words[1], path);
  else if (words[0] == "element" && words.size() == 3)
    header.elements.push_back(elementOf(words[1], words[2], path));
  else if (words[0] == "property" && words.size() >= 3 && !header.elements.empty())
    header.elements.back().properties.push_back(propertyOf(words, path));
  else
    throw IoError(path, fmt::format("has the line '{}' in its header, which is none of PLY", line));
  return true;
}

/** Least number of bytes of all elements; a list counts with its length alone. */
std::uint64_t leastBytes(const PlyHeader& header) {
  std::uint64_t least = 0;
  for (const PlyElement& element : header.elements)
    for (const PlyProperty& property : element.properties) {
      const bool is_text = header.encoding == PlyHeader::Encoding::text;  // a digit and a blank
      least += element.count * (is_text ? 2 : sizeOf(property.is_list ? property.length : property.type));
    }
  return least > 0 && header.encoding == PlyHeader::Encoding::text ? least - 1 : least;
}

/** The header of a file, checked against the length of the data. */
PlyHeader headerOf(std::string_view bytes, const std::string& path) {
  constexpr std::size_t kFirst = 3;  // bytes
  PlyHeader header;
  const std::string_view line_ends = bytes.substr(0, bytes.find_first_not_of(" \t\r\n", kFirst));
  const char newline = line_ends.find('\n') == std::string_view::npos ? '\r' : '\n';
  std::size_t at = bytes.find(newline);
  if (text::lower(std::string(text::trimmed(bytes.substr(0, at)))) != "ply")
    throw IoError(path, "is no PLY file: its first line is not 'ply'");
  for (bool more = true; more;) {
    const std::size_t line_end = at == std::string_view::npos ? at : bytes.find(newline, at + 1);
    if (line_end == std::string_view::npos) throw IoError(path, "has no end of its PLY header");
    more = take(text::trimmed(bytes.substr(at + 1, line_end - at - 1)), path, header);
    at = line_end;
  }
  header.end = at + 1;
  if (leastBytes(header) > bytes.size() - header.end)
    throw IoError(path, fmt::format("is cut off: its header promises at least {} bytes, {} are there",
                                    leastBytes(header), bytes.size() - header.end));
  return header;
}

/** The numbers behind a header, one after the other. All of them are exact as doubles. */
class PlyNumbers {
public:
  PlyNumbers(std::string_view rest, PlyHeader::Encoding encoding, const std::string& path)
      : rest_(rest), encoding_(encoding), path_(path) {}

  double next(std::uint8_t type) { return encoding_ == PlyHeader::Encoding::text ? word() : binary(type); }
  /** Throws IoError unless that number of values may follow. */
  void requireRoomFor(std::size_t n, std::uint8_t type) const {
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
  double binary(std::uint8_t type) {
    const std::size_t size = sizeOf(type);
    if (rest_.size() < size) failCutOff();
    std::array<char, sizeof(double)> bytes{};
    std::copy_n(rest_.begin(), size, bytes.begin());
    if (encoding_ == PlyHeader::Encoding::big_endian)
      std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    rest_.remove_prefix(size);
    return numberAt(type, bytes.data());
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

pcl::PolygonMesh readPly(const fs::path& path) {
  files::requireRegularFile(path);
  const std::string bytes = files::asUtf8(files::readBytes(path)), name = path.string();
  const PlyHeader header = headerOf(bytes, name);
  PlyNumbers numbers(std::string_view(bytes).substr(header.end), header.encoding, name);
  PlyReader reader(name);
  for (const PlyElement& element : header.elements) reader.read(element, numbers);
  return reader.mesh();
}

void writePly(std::ostream& out, const pcl::PolygonMesh& mesh) {
  const bool coloured = fieldOf(mesh.cloud, "rgb") != nullptr;
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
