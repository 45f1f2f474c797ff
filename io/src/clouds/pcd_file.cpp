// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "bytes/lzf.h"
#include "clouds/point_formats.h"

#include <facetloc/io/atomic_file.h>

#include <pcl/common/io.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace facetloc {
namespace {

constexpr std::size_t kMaxHeaderBytes = 65536;
constexpr std::uint64_t kMaxSide = 65535;
constexpr std::uint64_t kMaxCount = 65535;
constexpr std::uint64_t kMaxDataBytes = 1ull << 31;  // pcl::PCLPointCloud2 counts in 32 bits
constexpr std::uint64_t kLzfMaxRatio = 88;           // LZF unpacks 3 bytes to 264 at most
constexpr std::string_view kOrder[] = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                       "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};

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
std::string bodyOf(const fs::path& path, const PcdHeader& header) {
  std::ifstream in(path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(header.data_offset));
  std::string body{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in.good() && !in.eof()) throw IoError(path.string(), "cannot be read");
  return body;
}

/** Calls visit(Number()) with the type of number of a field. */
template <class Visit>
auto visitType(std::uint8_t type, const Visit& visit) -> decltype(visit(double())) {
  switch (type) {
  case Field::INT8:
    return visit(std::int8_t());
  case Field::UINT8:
    return visit(std::uint8_t());
  case Field::INT16:
    return visit(std::int16_t());
  case Field::UINT16:
    return visit(std::uint16_t());
  case Field::INT32:
    return visit(std::int32_t());
  case Field::UINT32:
    return visit(std::uint32_t());
  case Field::INT64:
    return visit(std::int64_t());
  case Field::UINT64:
    return visit(std::uint64_t());
  case Field::FLOAT32:
    return visit(float());
  default:
    return visit(double());
  }
}

bool putNumber(const Field& field, std::string_view word, std::uint8_t* place) {
  const auto put = [&](auto zero) {
    const auto number = text::to<decltype(zero)>(word);
    if (number) std::memcpy(place, &*number, sizeof *number);
    return number.has_value();
  };
  // Despite its type, PCL writes an rgb field as the whole number that its bytes are.
  if (field.name == "rgb" && field.datatype == Field::FLOAT32 && put(std::uint32_t())) return true;
  return visitType(field.datatype, put);
}

void readText(const std::string& body, const PcdHeader& header, const std::string& path,
              std::vector<std::uint8_t>& data) {
  WordReader words(body);
  std::uint8_t* place = data.data();
  for (std::size_t point = 0; point < header.points; ++point)
    for (const Field& field : header.fields)
      for (std::uint32_t k = 0; k < field.count; ++k, place += pcl::getFieldSize(field.datatype)) {
        const std::string_view word = words.next();
        if (word.empty())
          throw IoError(path, fmt::format("is truncated: it ends in point {} of {}", point, header.points));
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
  for (const Field& field : header.fields) {
    const std::size_t size = field.count * static_cast<std::size_t>(pcl::getFieldSize(field.datatype));
    for (std::size_t point = 0; point < header.points; ++point, from += size)
      std::memcpy(data.data() + point * header.step + field.offset, from, size);
  }
  return true;
}

/** The letter of a type in a header. */
char letterOf(std::uint8_t type) {
  return visitType(type, [](auto zero) {
    using Number = decltype(zero);
    return std::is_floating_point_v<Number> ? 'F' : std::is_signed_v<Number> ? 'I' : 'U';
  });
}

std::string headerOf(const pcl::PCLPointCloud2& points, std::vector<double> viewpoint) {
  if (viewpoint.empty()) viewpoint = {0, 0, 0, 1, 0, 0, 0};
  std::string names, sizes, types, counts;
  for (const Field& field : points.fields) {
    names += ' ' + field.name;
    sizes += fmt::format(" {}", pcl::getFieldSize(field.datatype));
    types += fmt::format(" {}", letterOf(field.datatype));
    counts += fmt::format(" {}", field.count);
  }
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS{}\nSIZE{}\nTYPE{}\nCOUNT{}\nWIDTH {}\n"
      "HEIGHT {}\nVIEWPOINT {}\nPOINTS {}\nDATA binary_compressed\n",
      names, sizes, types, counts, points.width, points.height, fmt::join(viewpoint, " "),
      std::size_t(points.width) * points.height);
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

/** No numbers unless there are seven. */
std::vector<double> sevenIn(const std::vector<std::string_view>& words) {
  std::vector<double> found;
  for (std::size_t i = 1; i < words.size(); ++i)
    if (const auto value = text::to<double>(words[i])) found.push_back(*value);
  if (found.size() != 7 || words.size() != 8) found.clear();
  return found;
}

/** Reads the lines of a header, each once and in the order of the format. */
class HeaderReader {
public:
  using Words = std::vector<std::string_view>;

  HeaderReader(const std::string& path, bool may_be_empty, PcdHeader& header)
      : path_(path), least_width_(may_be_empty ? 0 : 1), header_(header) {}

  void read(std::istream& in) {
    std::string start(kMaxHeaderBytes, '\0');
    in.read(start.data(), static_cast<std::streamsize>(start.size()));
    start.resize(static_cast<std::size_t>(in.gcount()));
    if (start.empty()) throw IoError(path_, "is empty");
    parse(start);
    requireSound();
    in.clear();
    in.seekg(0, std::ios::end);
    requireLength(in, static_cast<std::uint64_t>(in.tellg()));
  }

private:
  [[noreturn]] void fail(const std::string& cause) const { throw IoError(path_, cause); }

  void parse(std::string_view start) {
    const auto* next = std::begin(kOrder);
    if (start.rfind("\xFF\xFE", 0) == 0 || start.rfind("\xFE\xFF", 0) == 0)
      fail("is in UTF-16: save it as UTF-8 (ascii)");
    if (start.rfind("\xEF\xBB\xBF", 0) == 0) start.remove_prefix(header_.data_offset = 3);
    while (!start.empty()) {
      const std::size_t length = std::min(start.find('\n'), start.size() - 1) + 1;
      Words words = text::words(start.substr(0, length));
      start.remove_prefix(length);
      header_.data_offset += length;
      if (words.empty() || words[0].front() == '#') continue;
      const auto* key = std::find_if(next, std::end(kOrder), [&words](std::string_view known) {
        return text::lower(std::string(known)) == text::lower(std::string(words[0]));
      });
      if (key == std::end(kOrder)) fail("is not a PCD file, or its header is corrupt");
      next = key + 1;
      words[0] = *key;
      store(words);
      if (*key == "DATA") return;
    }
    fail("is not a PCD file, or is truncated: its header has no DATA line");
  }

  void store(const Words& words) {
    if (words[0] == "FIELDS") names_.assign(words.begin() + 1, words.end());
    if (words[0] == "SIZE") sizes_ = numbers(words);
    if (words[0] == "TYPE") types_.assign(words.begin() + 1, words.end());
    if (words[0] == "COUNT") counts_ = numbers(words);
    if (words[0] == "WIDTH") width_ = number(words);
    if (words[0] == "HEIGHT") height_ = number(words);
    if (words[0] == "VIEWPOINT") header_.viewpoint = sevenIn(words);
    if (words[0] == "POINTS") points_ = number(words);
    if (words[0] == "DATA") header_.encoding = words.size() == 2 ? text::lower(std::string(words[1])) : "";
  }

  std::vector<std::uint64_t> numbers(const Words& words) const {
    std::vector<std::uint64_t> found;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto value = text::to<std::uint64_t>(words[i]);
      if (!value) fail(fmt::format("has a corrupt header: '{}' is not a count", words[i]));
      found.push_back(*value);
    }
    return found;
  }

  std::uint64_t number(const Words& words) const {
    const auto found = numbers(words);
    if (found.size() != 1) fail(fmt::format("has a corrupt header: {} is not one number", words[0]));
    return found[0];
  }

  void requireSound() {
    if (counts_.empty()) counts_.assign(names_.size(), 1);
    if (names_.empty() || sizes_.size() != names_.size() || types_.size() != names_.size() ||
        counts_.size() != names_.size())
      fail("has a corrupt header: FIELDS, SIZE, TYPE and COUNT do not fit together");
    for (std::size_t i = 0; i < names_.size(); ++i) addField(i);
    const bool of_one_row = height_ == 1;  // a cloud that is not organized may have any number of points
    const bool sides_ok = width_ >= least_width_ && width_ <= (of_one_row ? kMaxDataBytes : kMaxSide) &&
                          height_ >= 1 && height_ <= kMaxSide;
    if (!sides_ok || points_ != width_ * height_)
      fail("has a corrupt header: WIDTH, HEIGHT and POINTS do not fit together");
    if (points_ > kMaxDataBytes / header_.step) fail("has a corrupt header: it promises too many points");
    header_.width = static_cast<int>(width_), header_.height = static_cast<int>(height_),
    header_.points = points_;
  }

  void addField(std::size_t i) {
    std::uint8_t type = Field::INT8;
    while (type <= Field::UINT64 && (types_[i] != std::string(1, letterOf(type)) ||
                                     sizes_[i] != static_cast<std::uint64_t>(pcl::getFieldSize(type))))
      ++type;
    if (type > Field::UINT64 || counts_[i] < 1 || counts_[i] > kMaxCount)
      fail("has a corrupt header: FIELDS, SIZE, TYPE and COUNT do not fit together");
    Field field;
    field.name = names_[i];
    field.datatype = type;
    field.count = static_cast<std::uint32_t>(counts_[i]);
    field.offset = static_cast<std::uint32_t>(header_.step);
    header_.fields.push_back(field);
    header_.step += sizes_[i] * counts_[i];
  }

  void requireLength(std::istream& in, std::uint64_t file_size) const {
    const std::uint64_t body = file_size - std::min<std::uint64_t>(file_size, header_.data_offset);
    const std::uint64_t promised = points_ * header_.step;
    const auto requireBytes = [&](std::uint64_t needed) {
      if (body < needed) fail(fmt::format("is truncated: {} bytes of points instead of {}", body, needed));
    };
    if (header_.encoding == "ascii") {
      std::uint64_t values = 0;
      for (const std::uint64_t count : counts_) values += points_ * count;
      requireBytes(std::max<std::uint64_t>(2 * values, 1) - 1);  // a digit and a blank each
    } else if (header_.encoding == "binary") {
      requireBytes(promised);
    } else if (header_.encoding == "binary_compressed") {
      std::uint32_t sizes[2] = {0, 0};  // packed, unpacked
      requireBytes(sizeof sizes);
      in.seekg(static_cast<std::streamoff>(header_.data_offset));
      in.read(reinterpret_cast<char*>(sizes), sizeof sizes);
      requireBytes(sizeof sizes + sizes[0]);
      if (sizes[1] != promised || promised > kLzfMaxRatio * sizes[0])
        fail("is corrupt: its compressed size does not fit its header");
    } else {
      fail("has a corrupt header: unknown DATA " + text::quoted(header_.encoding));
    }
  }

  const std::string& path_;
  const std::uint64_t least_width_;
  PcdHeader& header_;
  std::vector<std::string> names_, types_;
  std::vector<std::uint64_t> sizes_, counts_;
  std::uint64_t width_ = 0, height_ = 0, points_ = 0;
};

}  // namespace

PcdHeader::PcdHeader(const fs::path& path, bool may_be_empty) {
  files::requireRegularFile(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw IoError(path.string(), "cannot be opened: " + files::lastError());
  const std::string name = path.string();
  HeaderReader(name, may_be_empty, *this).read(in);
}

pcl::PCLPointCloud2 readPcd(const fs::path& path, const PcdHeader& header, Eigen::Isometry3d* viewpoint) {
  pcl::PCLPointCloud2 cloud;
  cloud.width = static_cast<std::uint32_t>(header.width);
  cloud.height = static_cast<std::uint32_t>(header.height);
  cloud.fields = header.fields;
  cloud.point_step = static_cast<std::uint32_t>(header.step);
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.is_dense = false;
  cloud.data.resize(header.points * header.step);
  const std::string body = bodyOf(path, header);
  if (header.encoding == "ascii")
    readText(body, header, path.string(), cloud.data);
  else if (header.encoding == "binary")
    std::memcpy(cloud.data.data(), body.data(), cloud.data.size());
  else if (!readCompressed(body, header, cloud.data))
    throw IoError(path.string(), "is a corrupt PCD file: its points cannot be unpacked");
  if (viewpoint) *viewpoint = poseOf(header.viewpoint);
  return cloud;
}

void writePcd(const fs::path& path, const pcl::PCLPointCloud2& points, const std::vector<double>& viewpoint) {
  const std::string columns = columnsOf(points), packed = lzfPacked(columns);
  const std::uint32_t sizes[] = {static_cast<std::uint32_t>(packed.size()),
                                 static_cast<std::uint32_t>(columns.size())};
  if (sizes[1] != columns.size())
    throw IoError(path.string(), "cannot be written: a PCD file holds less than 4 GB of points");
  writeTextAtomically(path, [&](std::ostream& out) {
    out << headerOf(points, viewpoint);
    out.write(reinterpret_cast<const char*>(sizes), sizeof sizes);
    out << packed;
  });
}

const pcl::PCLPointField* fieldOf(const pcl::PCLPointCloud2& cloud, std::string_view name) {
  const auto field = std::find_if(cloud.fields.begin(), cloud.fields.end(),
                                  [name](const Field& f) { return f.name == name; });
  return field == cloud.fields.end() ? nullptr : &*field;
}

bool isFloatingPoint(const Field& field) {
  return field.datatype == Field::FLOAT32 || field.datatype == Field::FLOAT64;
}

double numberAt(std::uint8_t type, const void* bytes) {
  return visitType(type, [bytes](auto number) {
    std::memcpy(&number, bytes, sizeof number);
    return static_cast<double>(number);
  });
}

}  // namespace facetloc
