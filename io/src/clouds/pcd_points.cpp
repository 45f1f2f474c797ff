// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/pcd_points.h"

#include "base/text.h"
#include "bytes/lzf.h"
#include "bytes/word_reader.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <pcl/common/io.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace facetloc {

namespace {

using Field = pcl::PCLPointField;

Eigen::Isometry3d poseOf(const std::vector<double>& viewpoint) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (viewpoint.empty()) return T;
  const Eigen::Vector3f t(Eigen::Map<const Eigen::Vector3d>(viewpoint.data()).cast<float>());
  const Eigen::Quaternionf q(
      Eigen::Quaterniond(viewpoint[3], viewpoint[4], viewpoint[5], viewpoint[6]).cast<float>());
  if (!t.allFinite() || !q.coeffs().allFinite() || !(q.norm() > 0.5)) return T;
  T.linear() = q.cast<double>().normalized().toRotationMatrix();
  T.translation() = t.cast<double>();
  return T;
}

/** The data after the header. */
std::string bodyOf(const std::filesystem::path& path, const PcdHeader& header) {
  std::ifstream in(path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(header.dataOffset()));
  std::string body{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in.good() && !in.eof()) throw IoError(path.string(), "cannot be read");
  return body;
}

template <class Number>
bool put(std::string_view word, std::uint8_t* place) {
  const auto number = text::to<Number>(word);
  if (number) std::memcpy(place, &*number, sizeof *number);
  return number.has_value();
}

/** Despite its type, PCL writes an rgb field as the whole number that its bytes are. */
bool putFloat(const Field& field, std::string_view word, std::uint8_t* place) {
  return (field.name == "rgb" && put<std::uint32_t>(word, place)) || put<float>(word, place);
}

bool putNumber(const Field& field, std::string_view word, std::uint8_t* place) {
  switch (field.datatype) {
  case Field::INT8:
    return put<std::int8_t>(word, place);
  case Field::UINT8:
    return put<std::uint8_t>(word, place);
  case Field::INT16:
    return put<std::int16_t>(word, place);
  case Field::UINT16:
    return put<std::uint16_t>(word, place);
  case Field::INT32:
    return put<std::int32_t>(word, place);
  case Field::UINT32:
    return put<std::uint32_t>(word, place);
  case Field::INT64:
    return put<std::int64_t>(word, place);
  case Field::UINT64:
    return put<std::uint64_t>(word, place);
  case Field::FLOAT32:
    return putFloat(field, word, place);
  default:
    return put<double>(word, place);
  }
}

void readText(const std::string& body, const PcdHeader& header, const std::string& path,
              std::vector<std::uint8_t>& data) {
  WordReader words(body);
  std::uint8_t* place = data.data();
  for (std::size_t point = 0; point < header.points(); ++point)
    for (const Field& field : header.fields())
      for (std::uint32_t k = 0; k < field.count; ++k, place += pcl::getFieldSize(field.datatype)) {
        const std::string_view word = words.next();
        if (word.empty())
          throw IoError(path, fmt::format("is truncated: it ends in point {} of {}", point, header.points()));
        if (!putNumber(field, word, place))
          throw IoError(path, fmt::format("is corrupt: '{}' is no {} of point {}", word, field.name, point));
      }
}

/** Compressed are all values of the first field, then all of the second, ... */
bool readCompressed(const std::string& body, const PcdHeader& header, std::vector<std::uint8_t>& data) {
  std::uint32_t packed = 0;
  constexpr std::size_t kSizes = 2 * sizeof packed;
  std::memcpy(&packed, body.data(), sizeof packed);
  std::vector<std::uint8_t> columns(data.size());
  if (!lzfUnpack(std::string_view(body).substr(kSizes, packed), columns)) return false;
  const std::uint8_t* from = columns.data();
  for (const Field& field : header.fields()) {
    const std::size_t size = field.count * static_cast<std::size_t>(pcl::getFieldSize(field.datatype));
    for (std::size_t point = 0; point < header.points(); ++point, from += size)
      std::memcpy(data.data() + point * header.step() + field.offset, from, size);
  }
  return true;
}

/** The letter of a type in a header. */
char letterOf(std::uint8_t type) {
  switch (type) {
  case Field::FLOAT32:
  case Field::FLOAT64:
    return 'F';
  case Field::INT8:
  case Field::INT16:
  case Field::INT32:
  case Field::INT64:
    return 'I';
  default:
    return 'U';
  }
}

std::string headerOf(const pcl::PCLPointCloud2& points) {
  std::string names, sizes, types, counts;
  for (const Field& field : points.fields) {
    names += ' ' + field.name;
    sizes += fmt::format(" {}", pcl::getFieldSize(field.datatype));
    types += fmt::format(" {}", letterOf(field.datatype));
    counts += fmt::format(" {}", field.count);
  }
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS{}\nSIZE{}\nTYPE{}\nCOUNT{}\nWIDTH {}\n"
      "HEIGHT {}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary_compressed\n",
      names, sizes, types, counts, points.width, points.height, std::size_t(points.width) * points.height);
}

/** All values of the first field, then all of the second, ..., without padding between fields. */
std::string columnsOf(const pcl::PCLPointCloud2& points) {
  const std::size_t n = std::size_t(points.width) * points.height;
  std::string columns;
  for (const Field& field : points.fields) {
    const std::size_t size = field.count * static_cast<std::size_t>(pcl::getFieldSize(field.datatype));
    for (std::size_t i = 0; i < n; ++i)
      columns.append(reinterpret_cast<const char*>(points.data.data()) + i * points.point_step + field.offset,
                     size);
  }
  return columns;
}

}  // namespace

pcl::PCLPointCloud2 readPcd(const std::filesystem::path& path, const PcdHeader& header,
                            Eigen::Isometry3d* viewpoint) {
  pcl::PCLPointCloud2 cloud;
  cloud.width = static_cast<std::uint32_t>(header.width());
  cloud.height = static_cast<std::uint32_t>(header.height());
  cloud.fields = header.fields();
  cloud.point_step = static_cast<std::uint32_t>(header.step());
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.is_dense = false;
  cloud.data.resize(header.points() * header.step());
  const std::string body = bodyOf(path, header);
  if (header.encoding() == "ascii")
    readText(body, header, path.string(), cloud.data);
  else if (header.encoding() == "binary")
    std::memcpy(cloud.data.data(), body.data(), cloud.data.size());
  else if (!readCompressed(body, header, cloud.data))
    throw IoError(path.string(), "is a corrupt PCD file: its points cannot be unpacked");
  if (viewpoint) *viewpoint = poseOf(header.viewpoint());
  return cloud;
}

void writePcd(const std::filesystem::path& path, const pcl::PCLPointCloud2& points) {
  const std::string columns = columnsOf(points), packed = lzfPacked(columns);
  const std::uint32_t sizes[] = {static_cast<std::uint32_t>(packed.size()),
                                 static_cast<std::uint32_t>(columns.size())};
  if (sizes[1] != columns.size())
    throw IoError(path.string(), "cannot be written: a PCD file holds less than 4 GB of points");
  writeTextAtomically(path, [&](std::ostream& out) {
    out << headerOf(points);
    out.write(reinterpret_cast<const char*>(sizes), sizeof sizes);
    out << packed;
  });
}

}  // namespace facetloc
