// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"
#include "bytes/files.h"

#include <facetloc/io/error.h>

#include <pcl/PCLPointField.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace facetloc {

/** \brief The header of a PCD file, read strictly and compared with the size of the file: it promises no more
 * than the file has. */
class PcdHeader {
public:
  /** \brief Throws IoError for anything that is not a sound PCD file of the promised length, or has no point,
   * unless it may be empty. */
  explicit PcdHeader(const std::filesystem::path& path, bool may_be_empty = false)
      : path_(path.string()), least_width_(may_be_empty ? 0 : 1) {
    files::requireRegularFile(path);
    std::ifstream in(path, std::ios::binary);
    if (!in) throw IoError(path_, "cannot be opened: " + files::lastError());
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

  int width() const { return static_cast<int>(width_); }
  int height() const { return static_cast<int>(height_); }
  std::size_t points() const { return points_; }
  /** \brief Fields in their order, packed. */
  const std::vector<pcl::PCLPointField>& fields() const { return fields_; }
  /** \brief Bytes of a point. */
  std::size_t step() const { return step_; }
  /** \brief x y z qw qx qy qz of the sensor; no numbers if the header says nothing. */
  const std::vector<double>& viewpoint() const { return viewpoint_; }
  /** \brief "ascii", "binary" or "binary_compressed". */
  const std::string& encoding() const { return encoding_; }
  /** \brief Where the points begin in the file. */
  std::uint64_t dataOffset() const { return data_offset_; }

private:
  static constexpr std::size_t kMaxHeaderBytes = 65536;
  static constexpr std::uint64_t kMaxSide = 65535;
  static constexpr std::uint64_t kMaxCount = 65535;
  static constexpr std::uint64_t kMaxDataBytes = 1ull << 31;  // pcl::PCLPointCloud2 counts in 32 bits
  static constexpr std::uint64_t kLzfMaxRatio = 88;           // LZF unpacks 3 bytes to 264 at most

  using Words = std::vector<std::string_view>;

  static constexpr std::string_view kOrder[] = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                                "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};

  [[noreturn]] void fail(const std::string& cause) const { throw IoError(path_, cause); }

  /** Each line once, and in the order of the format. */
  void parse(std::string_view start) {
    const auto* next = std::begin(kOrder);
    while (!start.empty()) {
      const std::size_t length = std::min(start.find('\n'), start.size() - 1) + 1;
      const Words words = text::words(start.substr(0, length));
      start.remove_prefix(length);
      data_offset_ += length;
      if (words.empty() || words[0].front() == '#') continue;
      const auto* key = std::find(next, std::end(kOrder), words[0]);
      if (key == std::end(kOrder)) fail("is not a PCD file, or its header is corrupt");
      next = key + 1;
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
    if (words[0] == "VIEWPOINT") viewpoint_ = pose(words);
    if (words[0] == "POINTS") points_ = number(words);
    if (words[0] == "DATA") encoding_ = words.size() == 2 ? words[1] : "";
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

  /** No numbers unless there are seven. */
  static std::vector<double> pose(const Words& words) {
    std::vector<double> found;
    for (std::size_t i = 1; i < words.size(); ++i)
      if (const auto value = text::to<double>(words[i])) found.push_back(*value);
    if (found.size() != 7 || words.size() != 8) found.clear();
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
    if (points_ > kMaxDataBytes / step_) fail("has a corrupt header: it promises too many points");
  }

  void addField(std::size_t i) {
    using Field = pcl::PCLPointField;
    struct Type {
      std::string_view name;
      std::uint64_t size;
      std::uint8_t type;
    };
    static constexpr Type kTypes[] = {
        {"I", 1, Field::INT8},    {"I", 2, Field::INT16},  {"I", 4, Field::INT32},  {"I", 8, Field::INT64},
        {"U", 1, Field::UINT8},   {"U", 2, Field::UINT16}, {"U", 4, Field::UINT32}, {"U", 8, Field::UINT64},
        {"F", 4, Field::FLOAT32}, {"F", 8, Field::FLOAT64}};
    const auto* type = std::find_if(std::begin(kTypes), std::end(kTypes), [&](const Type& t) {
      return t.name == types_[i] && t.size == sizes_[i];
    });
    if (type == std::end(kTypes) || counts_[i] < 1 || counts_[i] > kMaxCount)
      fail("has a corrupt header: FIELDS, SIZE, TYPE and COUNT do not fit together");
    Field field;
    field.name = names_[i];
    field.datatype = type->type;
    field.count = static_cast<std::uint32_t>(counts_[i]);
    field.offset = static_cast<std::uint32_t>(step_);
    fields_.push_back(field);
    step_ += sizes_[i] * counts_[i];
  }

  void requireLength(std::istream& in, std::uint64_t file_size) const {
    const std::uint64_t body = file_size - std::min<std::uint64_t>(file_size, data_offset_);
    const std::uint64_t promised = points_ * step_;
    const auto requireBytes = [&](std::uint64_t needed) {
      if (body < needed) fail(fmt::format("is truncated: {} bytes of points instead of {}", body, needed));
    };
    if (encoding_ == "ascii") {
      std::uint64_t values = 0;
      for (const std::uint64_t count : counts_) values += points_ * count;
      requireBytes(std::max<std::uint64_t>(2 * values, 1) - 1);  // a digit and a blank each
    } else if (encoding_ == "binary") {
      requireBytes(promised);
    } else if (encoding_ == "binary_compressed") {
      std::uint32_t sizes[2] = {0, 0};  // packed, unpacked
      requireBytes(sizeof sizes);
      in.seekg(static_cast<std::streamoff>(data_offset_));
      in.read(reinterpret_cast<char*>(sizes), sizeof sizes);
      requireBytes(sizeof sizes + sizes[0]);
      if (sizes[1] != promised || promised > kLzfMaxRatio * sizes[0])
        fail("is corrupt: its compressed size does not fit its header");
    } else {
      fail("has a corrupt header: unknown DATA " + text::quoted(encoding_));
    }
  }

  std::string path_;
  std::uint64_t least_width_;
  std::vector<std::string> names_, types_;
  std::vector<std::uint64_t> sizes_, counts_;
  std::vector<pcl::PCLPointField> fields_;
  std::size_t step_ = 0;
  std::vector<double> viewpoint_;
  std::uint64_t width_ = 0, height_ = 0, points_ = 0;
  std::uint64_t data_offset_ = 0;
  std::string encoding_;
};

}  // namespace facetloc
