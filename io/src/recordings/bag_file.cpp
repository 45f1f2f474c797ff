// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS 1, after the public description of their format 2.0 (wiki.ros.org/Bags/Format/2.0). The file is
// read from its beginning; its indices, which an unfinished one lacks, are not needed and not believed.
#include "recordings/chunked_file.h"
#include "recordings/ros_messages.h"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <map>
#include <optional>
#include <string_view>

namespace facetloc::internal {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint8_t kMessage = 2, kHeader = 3, kChunk = 5, kConnection = 7;  // types of records

/** The named fields of a record, or of the data of a connection. */
class Fields {
public:
  explicit Fields(ByteView bytes) {
    MessageReader reader(bytes, WireFormat::ros1);
    while (!reader.atEnd()) {
      const ByteView field = reader.bytes();
      const std::string_view words(reinterpret_cast<const char*>(field.data), field.size);
      const std::size_t end = words.find('=');
      if (end == std::string_view::npos) throw BadMessage("has a field without a name");
      values_.emplace(words.substr(0, end), words.substr(end + 1));
    }
  }

  std::string_view text(const char* name) const {
    const auto value = values_.find(name);
    return value == values_.end() ? std::string_view() : value->second;
  }
  template <typename Number>
  Number number(const char* name) const {
    Number number;
    const std::string_view value = text(name);
    if (value.size() != sizeof number) throw BadMessage(fmt::format("has no field {} of its size", name));
    std::memcpy(&number, value.data(), sizeof number);
    return number;
  }

private:
  std::map<std::string_view, std::string_view> values_;  // within the bytes
};

class BagFile : public ChunkedFile {
public:
  explicit BagFile(const fs::path& path) : ChunkedFile(path) {
    if (!beginsWith(kMagic)) throw IoError(path.string(), "is no bag of ROS 1 of the format 2.0");
    if (!scan()) addFault("was never finished, or is torn: it is read as far as it goes");
    finish();
  }

  Bytes read(const MessageEntry& entry) const override {
    const auto chunk = unpacked(entry.place);
    try {
      const std::size_t begin = std::min<std::size_t>(entry.inner, chunk->size());
      MessageReader record({chunk->data() + begin, chunk->size() - begin}, WireFormat::ros1);
      record.bytes();
      const ByteView data = record.bytes();
      return {data.data, data.data + data.size};
    } catch (const BadMessage&) {
      throw IoError(path().string(), "has changed since it was opened");
    }
  }

private:
  /** The size in front of bytes; nothing where the file ends. */
  std::optional<std::uint32_t> sizeAt(std::uint64_t place) const {
    std::uint32_t value = 0;
    if (!readAt(place, reinterpret_cast<std::uint8_t*>(&value), sizeof value)) return {};
    return value;
  }

  /** \return is it there to its end? */
  bool scan() {
    constexpr std::uint32_t kLongestHeader = 1 << 20, kLongestDeclaration = 1 << 24;
    std::uint64_t place = kMagic.size();
    bool finished = true;
    while (place < size()) try {
        const auto head = sizeAt(place);
        const auto length = head ? sizeAt(place + 4 + *head) : std::nullopt;
        if (!length) return false;
        if (*head > kLongestHeader) throw BadMessage("claims too much");
        const Bytes header = bytesAt(place + 4, *head);
        const Fields fields(header);
        const std::uint64_t begin = place + 8 + *head, left = size() - begin;
        const bool whole = *length <= left;
        const auto op = fields.number<std::uint8_t>("op");
        if (op == kHeader) {
          if (!fields.text("encryptor").empty()) throw BadMessage("is encrypted, which is not read");
          finished = fields.number<std::uint64_t>("index_pos") != 0;
        }
        if (op == kChunk) readChunk(fields, begin, std::min<std::uint64_t>(*length, left), whole);
        if (op == kConnection && whole) {
          if (*length > kLongestDeclaration) throw BadMessage("claims too much");
          const Bytes data = bytesAt(begin, *length);
          declare(fields, data);
        }
        if (!whole) return false;
        place = begin + *length;
      } catch (const BadMessage& e) {
        throw IoError(path().string(), fmt::format("is corrupt at byte {}: it {}", place, e.what()));
      }
    return finished;
  }

  void readChunk(const Fields& fields, std::uint64_t begin, std::uint64_t packed, bool whole) {
    const std::string_view compression = fields.text("compression");
    const auto [index, records] = addChunk({begin, packed, fields.number<std::uint32_t>("size"),
                                            std::string(compression == "none" ? "" : compression)},
                                           whole, 0, "rosbag compress");
    if (!records) return;
    try {
      readRecords(*records, index);
    } catch (const BadMessage&) {
      if (whole) throw;
    }
  }

  void readRecords(ByteView records, std::size_t chunk) {
    MessageReader reader(records, WireFormat::ros1);
    while (!reader.atEnd()) {
      const ByteView header = reader.bytes();
      const auto at = static_cast<std::uint64_t>(header.data - records.data) - 4;
      const ByteView data = reader.bytes();
      const Fields fields(header);
      const auto op = fields.number<std::uint8_t>("op");
      if (op == kConnection) declare(fields, data);
      if (op == kMessage) note(fields, chunk, at);
    }
  }

  void declare(const Fields& fields, ByteView data) {
    topic_of_[fields.number<std::uint32_t>("conn")] =
        topicOf(std::string(fields.text("topic")), std::string(Fields(data).text("type")), WireFormat::ros1);
  }

  void note(const Fields& fields, std::size_t chunk, std::uint64_t at) {
    const auto topic = topic_of_.find(fields.number<std::uint32_t>("conn"));
    const auto time = fields.number<std::uint64_t>("time");  // seconds, and nanoseconds in its upper half
    const double written = static_cast<std::uint32_t>(time) + kNanosecond * static_cast<double>(time >> 32);
    topic == topic_of_.end() ? countUndeclared() : add({topic->second, written, chunk, at});
  }

  std::map<std::uint32_t, std::size_t> topic_of_;  // keyed by connection
};

}  // namespace

std::unique_ptr<const MessageFile> openRos1Bag(const fs::path& path) {
  return std::make_unique<const BagFile>(path);
}

}  // namespace facetloc::internal
