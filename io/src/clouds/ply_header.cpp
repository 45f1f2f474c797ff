// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/ply_header.h"

#include "base/text.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <optional>

namespace facetloc {
namespace {

struct Type {
  std::string_view name, other_name;
  PlyNumber number;
};
constexpr Type kTypes[] = {
    {"char", "int8", PlyNumber::int8},        {"uchar", "uint8", PlyNumber::uint8},
    {"short", "int16", PlyNumber::int16},     {"ushort", "uint16", PlyNumber::uint16},
    {"int", "int32", PlyNumber::int32},       {"uint", "uint32", PlyNumber::uint32},
    {"float", "float32", PlyNumber::float32}, {"double", "float64", PlyNumber::float64}};

std::optional<PlyNumber> typeNamed(std::string_view name) {
  const auto* type = std::find_if(std::begin(kTypes), std::end(kTypes),
                                  [&](const Type& t) { return name == t.name || name == t.other_name; });
  return type == std::end(kTypes) ? std::nullopt : std::optional(type->number);
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
  const auto length = is_list ? typeNamed(words[2]) : PlyNumber::uint8;
  if (!type || !length)
    throw IoError(path, fmt::format("has a property in its header whose type PLY does not know: {}",
                                    fmt::join(words, " ")));
  return {std::string(words.back()), *type, is_list, *length};
}

/** \return false after the last line. */
bool take(std::string_view line, const std::string& path, PlyHeader& header) {
  const std::vector<std::string_view> words = text::words(line);
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

}  // namespace

std::size_t sizeOf(PlyNumber type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

PlyHeader::PlyHeader(std::string_view bytes, const std::string& path) {
  if (text::trimmed(bytes.substr(0, bytes.find('\n'))) != "ply")
    throw IoError(path, "is no PLY file: its first line is not 'ply'");
  std::size_t at = bytes.find('\n');
  for (bool more = true; more;) {
    const std::size_t line_end = at == std::string_view::npos ? at : bytes.find('\n', at + 1);
    if (line_end == std::string_view::npos) throw IoError(path, "has no end of its PLY header");
    more = take(text::trimmed(bytes.substr(at + 1, line_end - at - 1)), path, *this);
    at = line_end;
  }
  end = at + 1;
  if (leastBytes(*this) > bytes.size() - end)
    throw IoError(path, fmt::format("is cut off: its header promises at least {} bytes, {} are there",
                                    leastBytes(*this), bytes.size() - end));
}

}  // namespace facetloc
