// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"
#include "recordings/ros_messages.h"

#include <facetloc/io/oni_file.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <optional>

namespace facetloc {
namespace {

// A recording is a header and records. A record is a header, fields, and data; all numbers little-endian.
constexpr std::size_t kFileHeader = 24;            // "NI10", version, last time stamp, number of nodes
constexpr std::uint32_t kRecordMark = 0x0052494E;  // "NIR"
constexpr std::size_t kRecordHeader = 28;     // mark, type, node, size with the fields, size of the data, ...
constexpr std::size_t kOldRecordHeader = 24;  // ... and an offset, which was of 32 bits before version 1.0.1
constexpr std::uint32_t kMostFields = 1u << 20;
constexpr std::uint32_t kMostData = 1u << 28;
constexpr int kMostPixels = 1 << 24;
constexpr auto kPacked = internal::WireFormat::ros1;  // numbers as in messages of ROS 1

enum RecordType : std::uint32_t {
  kNodeAdded4 = 0x02,  // found in versions 1.0.0.4 ...
  kIntProperty = 0x03,
  kRealProperty = 0x04,
  kTextProperty = 0x05,
  kGeneralProperty = 0x06,
  kNewData = 0x0A,
  kEnd = 0x0B,
  kNodeAdded5 = 0x0C,  // ... 1.0.0.5 ...
  kNodeAdded = 0x0D,   // ... and since
};
constexpr std::uint32_t kDepthNode = 2;
constexpr std::uint64_t kMillimetres = 100, kTenths = 101;  // formats of depth in OpenNI2

struct RecordHeader {
  std::uint32_t mark, type, node, fields, data;
};

/** Stored with a zero at its end. Of ASCII: OpenNI2 crashes on a name that is not. */
std::string nameIn(internal::MessageReader& fields) {
  const std::string name = fields.text();
  if (std::any_of(name.begin(), name.end(), [](char c) { return (c & 0x80) != 0; }))
    throw internal::BadMessage("has a name that is not ASCII");
  return name;
}

struct Corrupt : std::exception {};

/** The depth of an .oni frame from its bytes: 16-bit numbers as differences to the one before.
 *
 * A byte below E0 holds two differences, 6 - high and 6 - low nibble. A low nibble of F says that a longer
 * one follows, D that there is no second. E0 + n stands for 2n times the same number again, FF for a longer
 * difference: one byte from 80 on, 192 less the difference, or else two, high byte first, that are the number
 * itself. */
class Decoder {
public:
  /** \param size how many numbers there are. */
  Decoder(const std::vector<std::uint8_t>& bytes, std::size_t size) : bytes_(bytes), size_(size) {
    out_.reserve(size);
  }

  /** \param with_table the numbers are indices of a table, which stands in front: its size and its entries.
   * \return nothing if the bytes are not the code of that number of values. */
  std::vector<std::uint16_t> decode(bool with_table) try {
    if (with_table) readTable();
    value_ = word();
    put();
    while (next_ < bytes_.size()) code(byte());
    if (out_.size() != size_) throw Corrupt();
    return std::move(out_);
  } catch (const Corrupt&) {
    return {};
  }

private:
  static constexpr int kZero = 6;          // the nibble of no difference
  static constexpr int kLongZero = 192;    // the byte of no difference
  static constexpr int kLong = 0xFF;       // a longer difference follows
  static constexpr int kRepeat = 0xE0;     // more of the same
  static constexpr int kLongSecond = 0xF;  // as second nibble: a longer difference follows
  static constexpr int kNoSecond = 0xD;    // as second nibble: the number of numbers is odd

  int byte() {
    if (next_ >= bytes_.size()) throw Corrupt();
    return bytes_[next_++];
  }
  int word() {  // low byte first
    const int low = byte();
    return low | byte() << 8;
  }
  void readTable() {
    table_.resize(static_cast<std::size_t>(word()));
    for (std::uint16_t& entry : table_) entry = static_cast<std::uint16_t>(word());
    if (table_.empty()) throw Corrupt();
  }
  void put() {
    value_ &= 0xFFFF;
    const auto index = static_cast<std::size_t>(value_);
    if (out_.size() == size_ || (!table_.empty() && index >= table_.size())) throw Corrupt();
    out_.push_back(table_.empty() ? static_cast<std::uint16_t>(value_) : table_[index]);
  }
  void code(int c) {
    if (c == kLong) return longer();
    if (c >= kRepeat) {
      for (int i = 0; i < 2 * (c - kRepeat); ++i) put();
      return;
    }
    value_ -= (c >> 4) - kZero;
    put();
    const int second = c & 0xF;
    if (second == kLongSecond) return longer();
    if (second == kNoSecond) return;
    value_ -= second - kZero;
    put();
  }
  void longer() {
    const int high = byte();
    if (high & 0x80)
      value_ -= high - kLongZero;
    else
      value_ = high << 8 | byte();
    put();
  }

  const std::vector<std::uint8_t>& bytes_;
  std::size_t next_ = 0;
  std::size_t size_;
  std::vector<std::uint16_t> table_;
  std::vector<std::uint16_t> out_;
  int value_ = 0;
};

std::vector<std::uint8_t> readBytes(std::FILE* file, std::uint64_t offset, std::size_t size,
                                    const fs::path& path) {
  std::vector<std::uint8_t> bytes(size);
  if (fseeko(file, static_cast<off_t>(offset), SEEK_SET) != 0 ||
      std::fread(bytes.data(), 1, size, file) != size)
    throw IoError(path.string(), "is truncated, or cannot be read");
  return bytes;
}

}  // namespace

/** Walks through the records. */
class OniFileIndexer {
public:
  explicit OniFileIndexer(const fs::path& path) : path_(path) { out_.path_ = path; }

  OniFile index() {
    files::requireRegularFile(path_);
    file_ = files::open(path_);
    size_ = fs::file_size(path_);
    readFileHeader();
    while (!out_.finished_ && !ends_early_) readRecord();
    check();
    out_.bytes_ = position_;
    return std::move(out_);
  }

private:
  [[noreturn]] void fail(const std::string& cause) const { throw IoError(path_.string(), cause); }

  void readFileHeader() {
    if (size_ < kFileHeader) fail("is no .oni recording");
    const internal::Bytes bytes = readBytes(file_.get(), 0, kFileHeader, path_);
    internal::MessageReader header(bytes, kPacked);
    if (header.number<std::uint32_t>() != 0x3031494E) fail("is no .oni recording");  // "NI10"
    const int major = header.number<std::uint8_t>(), minor = header.number<std::uint8_t>();
    const int maintenance = header.number<std::uint16_t>();
    if (major != 1 || minor != 0) fail("is of an unknown version of the .oni format");
    header_size_ = maintenance >= 1 ? kRecordHeader : kOldRecordHeader;
    position_ = kFileHeader;
  }

  /** A recorder that was killed leaves a record that is not all there. */
  void readRecord() {
    ends_early_ = position_ + header_size_ > size_;
    if (ends_early_) return;
    RecordHeader header;
    std::memcpy(&header, readBytes(file_.get(), position_, header_size_, path_).data(), sizeof header);
    ends_early_ = header.mark == 0 && onlyZerosFrom(position_);  // room that the file system had made
    if (ends_early_) return;
    const bool sound = header.mark == kRecordMark && header.fields >= header_size_ &&
                       header.fields <= kMostFields && header.data <= kMostData;
    if (!sound) fail(fmt::format("is corrupt at byte {}", position_));
    ends_early_ = position_ + header.fields + header.data > size_;
    if (ends_early_) return;
    try {
      readFields(header);
    } catch (const internal::BadMessage&) {
      fail(fmt::format("is corrupt at byte {}", position_));
    }
    position_ += header.fields + header.data;
    out_.finished_ = header.type == kEnd;
  }

  bool onlyZerosFrom(std::uint64_t position) const {
    constexpr std::uint64_t kPart = 1 << 16;
    for (; position < size_; position += kPart) {
      const auto bytes = readBytes(file_.get(), position,
                                   static_cast<std::size_t>(std::min(kPart, size_ - position)), path_);
      if (std::any_of(bytes.begin(), bytes.end(), [](std::uint8_t byte) { return byte != 0; })) return false;
    }
    return true;
  }

  void readFields(const RecordHeader& header) {
    const internal::Bytes bytes =
        readBytes(file_.get(), position_ + header_size_, header.fields - header_size_, path_);
    internal::MessageReader fields(bytes, kPacked);
    switch (header.type) {
    case kNodeAdded4:
    case kNodeAdded5:
    case kNodeAdded:
      return addNode(header.node, fields);
    case kRealProperty:
    case kTextProperty:
      nameIn(fields);
      return;
    case kIntProperty:
    case kGeneralProperty:
      return setProperty(header.node, fields);
    case kNewData:
      if (depth_ == header.node)
        out_.frames_.push_back({fields.number<std::uint64_t>(), position_ + header.fields, header.data});
      return;
    default:
      return;
    }
  }

  void addNode(std::uint32_t node, internal::MessageReader& fields) {
    nameIn(fields);
    const auto type = fields.number<std::uint32_t>();
    const auto codec = fields.number<std::uint32_t>();
    if (type != kDepthNode || depth_) return;
    depth_ = node;
    char name[5] = {};
    std::memcpy(name, &codec, sizeof codec);
    if (!std::strcmp(name, "NONE"))
      out_.codec_ = OniFile::Codec::none;
    else if (!std::strcmp(name, "16zP"))
      out_.codec_ = OniFile::Codec::differences;
    else if (!std::strcmp(name, "16zT"))
      out_.codec_ = OniFile::Codec::differences_of_table;
    else
      fail("has depth of an unknown coding " + text::quoted(name));
  }

  void setProperty(std::uint32_t node, internal::MessageReader& fields) {
    const std::string name = nameIn(fields);
    if (node != depth_) return;
    const auto size = fields.number<std::uint32_t>();
    if (name == "xnMirror" && size == sizeof(std::uint64_t)) {
      out_.mirrored_ = fields.number<std::uint64_t>() != 0;
    } else if (name == "oniPixelFormat" && size == sizeof(std::uint64_t)) {
      const auto format = fields.number<std::uint64_t>();
      if (format != kMillimetres && format != kTenths) fail("has depth in an unknown unit");
      setOnce(out_.millimetres_, format == kTenths ? 0.1 : 1.0, "unit");
    } else if (name == "xnMapOutputMode" && size == 3 * sizeof(std::uint32_t)) {
      const auto width = fields.number<std::uint32_t>(), height = fields.number<std::uint32_t>();
      const auto rate = fields.number<std::uint32_t>();
      if (width < 1 || height < 1 || std::uint64_t(width) * height > kMostPixels)
        fail("has depth of an impossible size");
      setOnce(out_.camera_.width, static_cast<int>(width), "size");
      setOnce(out_.camera_.height, static_cast<int>(height), "size");
      out_.rate_ = static_cast<int>(std::min(rate, 1000u));
    } else if (name == "xnFOV" && size == 2 * sizeof(double)) {
      horizontal_ = fields.number<double>();
      vertical_ = fields.number<double>();
    } else if (name == "xnCropping" && size == 6 * sizeof(std::uint16_t)) {
      if (fields.number<std::uint16_t>() != 0) fail("has depth that is cropped");
    }
  }

  template <typename T>
  void setOnce(T& value, T is, const char* what) {
    if (!out_.frames_.empty() && value != is) fail(fmt::format("has depth that changes its {}", what));
    value = is;
  }

  void check() {
    const std::string truncated = ends_early_ ? "is truncated, and " : "";
    if (!depth_) fail(truncated + "has no depth stream");
    if (out_.frames_.empty()) fail(truncated + "has no depth frames");
    Intrinsics& camera = out_.camera_;
    if (camera.width < 1) fail("does not state the size of its depth frames");
    constexpr double kWidest = 3;  // [rad]
    const bool has_view = horizontal_ > 0 && horizontal_ < kWidest && vertical_ > 0 && vertical_ < kWidest;
    if (!has_view) return;
    camera.fx = camera.width / (2 * std::tan(horizontal_ / 2));
    camera.fy = camera.height / (2 * std::tan(vertical_ / 2));
    camera.cx = (camera.width - 1) / 2.0;
    camera.cy = (camera.height - 1) / 2.0;
  }

  fs::path path_;
  files::FilePtr file_;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
  bool ends_early_ = false;
  std::size_t header_size_ = kRecordHeader;
  std::optional<std::uint32_t> depth_;  // the node that it is
  double horizontal_ = 0, vertical_ = 0;
  OniFile out_;
};

OniFile OniFile::open(const fs::path& path) { return OniFileIndexer(path).index(); }

std::vector<std::uint16_t> OniFile::readRaw(std::size_t index) const {
  const Frame& frame = frames_.at(index);
  const auto file = files::open(path_);
  const auto bytes = readBytes(file.get(), frame.offset, frame.size, path_);
  const std::size_t pixels = static_cast<std::size_t>(camera_.width) * camera_.height;
  std::vector<std::uint16_t> depth;
  if (codec_ != Codec::none) {
    depth = Decoder(bytes, pixels).decode(codec_ == Codec::differences_of_table);
  } else if (bytes.size() == pixels * sizeof(std::uint16_t)) {
    depth.resize(pixels);
    std::memcpy(depth.data(), bytes.data(), bytes.size());
  }
  if (depth.empty()) throw IoError(path_.string(), fmt::format("frame {} is corrupt", index));
  return depth;
}

void OniFile::requireSound() const {
  for (std::size_t i = 0; i < size(); ++i) readRaw(i);
}

DepthImage OniFile::read(std::size_t index) const {
  const std::vector<std::uint16_t> raw = readRaw(index);
  DepthImage image{camera_, std::vector<float>(raw.size())};
  const double scale = 1000 / millimetres_;  // divided, as for PNGs: the same depth is the same number
  std::transform(raw.begin(), raw.end(), image.depth.begin(),
                 [scale](std::uint16_t value) { return static_cast<float>(value / scale); });
  return image;
}

}  // namespace facetloc
