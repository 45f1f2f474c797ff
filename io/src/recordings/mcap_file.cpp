// SPDX-License-Identifier: BSD-3-Clause
// MCAP, after its public specification (mcap.dev/spec). The file is read from its beginning; the index at its
// end, which an unfinished file lacks, is not needed and not believed.
#include "recordings/chunked_file.h"
#include "recordings/ros_messages.h"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <libdeflate.h>
#include <map>
#include <optional>
#include <string_view>

namespace facetloc::internal {
namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
constexpr std::size_t kRecordHead = 9;    // opcode, size of the rest
constexpr std::size_t kMessageHead = 22;  // channel, number, two times
constexpr std::uint64_t kUnchunked = ~std::uint64_t(0);

enum Opcode : std::uint8_t { kInvalid, kHeader, kFooter, kSchema, kChannel, kMessage, kChunk, kDataEnd = 15 };

/** The head of a record. */
struct Record {
  std::uint8_t opcode = kInvalid;
  std::uint64_t size = 0;
};

Record recordOf(const std::uint8_t* head) {
  Record record;
  record.opcode = head[0];
  std::memcpy(&record.size, head + 1, sizeof record.size);
  return record;
}

class McapFile : public ChunkedFile {
public:
  explicit McapFile(const fs::path& path) : ChunkedFile(path) {
    if (!beginsWith(kMagic)) throw IoError(path.string(), "is no MCAP file");
    scan();
    finish();
  }

  Bytes read(const MessageEntry& entry) const override {
    if (entry.place != kUnchunked) return readFromChunk(entry);
    const Record record = recordAt(entry.inner).value_or(Record());
    if (record.opcode != kMessage || record.size < kMessageHead || record.size > kLargestMessage)
      throw IoError(path().string(), fmt::format("has a corrupt message at byte {}", entry.inner));
    return bytesAt(entry.inner + kRecordHead + kMessageHead, record.size - kMessageHead);
  }

private:
  Bytes readFromChunk(const MessageEntry& entry) const {
    constexpr std::size_t kHeads = kRecordHead + kMessageHead;
    const auto chunk = unpacked(entry.place);
    const std::size_t left = chunk->size() - std::min<std::size_t>(entry.inner, chunk->size());
    const Record record = left < kHeads ? Record() : recordOf(chunk->data() + entry.inner);
    if (record.size < kMessageHead || record.size > left - kRecordHead)
      throw IoError(path().string(), "has changed since it was opened");
    const std::uint8_t* data = chunk->data() + entry.inner + kHeads;
    return {data, data + record.size - kMessageHead};
  }

  /** Nothing where the file ends. */
  std::optional<Record> recordAt(std::uint64_t place) const {
    std::uint8_t head[kRecordHead];
    if (size() - place < sizeof head || !readAt(place, head, sizeof head)) return {};
    return recordOf(head);
  }

  void scan() {
    std::uint64_t place = kMagic.size();
    while (true) {
      const auto record = recordAt(place);
      if (!record || record->opcode == kInvalid)
        return addFault("was never finished, or is torn: it is read as far as it goes");
      if (record->opcode == kDataEnd || record->opcode == kFooter) return checkData(place, *record);
      const std::uint64_t begin = place + kRecordHead, left = size() - begin;
      const std::uint64_t size = std::min(record->size, left);
      try {
        readRecord(record->opcode, place, size, record->size <= left);
      } catch (const BadMessage& e) {
        throw IoError(path().string(), fmt::format("is corrupt at byte {}: it {}", place, e.what()));
      }
      if (record->size > left) return addFault("was never finished: it is read as far as it goes");
      place = begin + size;
    }
  }

  /** \param whole is the record as long as it claims to be? */
  void readRecord(std::uint8_t opcode, std::uint64_t place, std::uint64_t size, bool whole) {
    const std::uint64_t begin = place + kRecordHead;
    if (opcode == kChunk) return readChunk(begin, size, whole);
    if (!whole || (opcode != kSchema && opcode != kChannel && opcode != kMessage)) return;
    constexpr std::uint64_t kLongestDeclaration = 1 << 24;
    if (opcode != kMessage && size > kLongestDeclaration) throw BadMessage("claims too much");
    const Bytes bytes =
        bytesAt(begin, opcode == kMessage ? std::min<std::uint64_t>(size, kMessageHead) : size);
    has_unchunked_ = has_unchunked_ || opcode == kMessage;
    note(opcode, bytes, kUnchunked, place);
  }

  /** Schemas, channels and messages, wherever they are. */
  void note(std::uint8_t opcode, ByteView bytes, std::uint64_t place, std::uint64_t inner) {
    MessageReader record(bytes, WireFormat::ros1);  // MCAP packs its own fields the same way
    if (opcode == kSchema) {
      const auto id = record.number<std::uint16_t>();
      if (id != 0) types_[id] = typeWithoutMsg(record.text());
    } else if (opcode == kChannel) {
      const auto id = record.number<std::uint16_t>();
      const std::string type = types_[record.number<std::uint16_t>()], name = record.text();
      const std::string encoding = record.text();
      topics_of_channels_[id] = topicOf(name, type,
                                        encoding == "cdr"    ? WireFormat::cdr
                                        : encoding == "ros1" ? WireFormat::ros1
                                                             : WireFormat::other);
    } else if (opcode == kMessage) {
      const auto topic = topics_of_channels_.find(record.number<std::uint16_t>());
      record.skip<std::uint32_t>(1);
      const auto written = record.number<std::uint64_t>();
      record.skip<std::uint64_t>(1);
      if (topic == topics_of_channels_.end())
        countUndeclared();
      else
        add({topic->second, kNanosecond * static_cast<double>(written), place, inner});
    }
  }

  void readChunk(std::uint64_t begin, std::uint64_t size, bool whole) {
    constexpr std::uint64_t kLongestHead = 1 << 10;
    const Bytes bytes = bytesAt(begin, std::min(size, kLongestHead));
    MessageReader head(bytes, WireFormat::ros1);
    ChunkPlace chunk;
    std::uint32_t expected = 0;
    try {
      head.skip<std::uint64_t>(2);  // the times of its first and last message
      chunk.unpacked = head.number<std::uint64_t>();
      expected = head.number<std::uint32_t>();
      chunk.compression = head.text();
      chunk.packed = head.number<std::uint64_t>();
    } catch (const BadMessage&) {
      if (whole) throw;
      return;  // torn within its head
    }
    const std::uint64_t used = 8 + 8 + 8 + 4 + 4 + chunk.compression.size() + 8;
    if (whole && chunk.packed > size - used) throw BadMessage("has a chunk that is longer than its record");
    chunk.begin = begin + used;
    chunk.packed = std::min(chunk.packed, size - used);
    const auto [index, records] = addChunk(chunk, whole, expected, "mcap compress");
    if (records) readRecordsOf(*records, index);
  }

  /** \param index of the chunk */
  void readRecordsOf(const Bytes& records, std::size_t index) {
    for (std::size_t at = 0; records.size() - at >= kRecordHead;) {
      const Record record = recordOf(records.data() + at);
      if (record.opcode == kInvalid || record.size > records.size() - at - kRecordHead) return;  // torn
      note(record.opcode, {records.data() + at + kRecordHead, static_cast<std::size_t>(record.size)}, index,
           at);
      at += kRecordHead + static_cast<std::size_t>(record.size);
    }
  }

  /** Messages outside of chunks have no checksum but the one over all data. */
  void checkData(std::uint64_t place, const Record& record) {
    std::uint32_t expected = 0;
    if (record.opcode != kDataEnd || record.size < sizeof expected || !has_unchunked_) return;
    if (!readAt(place + kRecordHead, reinterpret_cast<std::uint8_t*>(&expected), sizeof expected))
      return addFault("was never finished: it is read as far as it goes");
    if (expected == 0) return;
    constexpr std::uint64_t kPart = 1 << 20;
    std::uint32_t sum = 0;
    for (std::uint64_t at = 0; at < place; at += kPart) {
      const Bytes part = bytesAt(at, std::min(kPart, place - at));
      sum = libdeflate_crc32(sum, part.data(), part.size());
    }
    if (sum != expected) addFault("its data do not match its checksum: some are damaged");
  }

  bool has_unchunked_ = false;
  std::map<std::uint16_t, std::string> types_;
  std::map<std::uint16_t, std::size_t> topics_of_channels_;
};

}  // namespace

std::unique_ptr<const MessageFile> openMcap(const fs::path& path) {
  return std::make_unique<const McapFile>(path);
}

}  // namespace facetloc::internal
