// SPDX-License-Identifier: BSD-3-Clause
#include "maps/map_reader.h"
#include "maps/map_schema.h"

#include <algorithm>
#include <fmt/format.h>
#include <libdeflate.h>
#include <streambuf>

namespace facetloc::place_index_parts {

using namespace sqlite;

namespace {

constexpr std::size_t kPartSize = 1 << 20;  // [bytes]
constexpr const char* kTable = "place_index";

int checksum(const Blob& data) {  // as SQLite's signed integers
  return static_cast<int>(libdeflate_crc32(0, data.data(), data.size()));
}

/** Collects bytes, and inserts a part whenever there is enough. */
class PartsWriter : public std::streambuf {
public:
  explicit PartsWriter(Connection& db) : insert_(db, schema::insert(schema::kIndexColumns, kTable)) {}

  void finish() {
    if (!part_.empty()) insertPart();
  }

protected:
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char byte = traits_type::to_char_type(c);
    xsputn(&byte, 1);
    return c;
  }
  std::streamsize xsputn(const char* data, std::streamsize size) override {
    for (auto rest = static_cast<std::size_t>(size); rest > 0;) {
      const std::size_t n = std::min(rest, kPartSize - part_.size());
      part_.insert(part_.end(), data, data + n);
      data += n, rest -= n;
      if (part_.size() == kPartSize) insertPart();
    }
    return size;
  }

private:
  void insertPart() {
    (insert_ << number_++ << checksum(part_) << part_).run();
    part_.clear();
  }

  Statement insert_;
  Blob part_;
  int number_ = 0;
};

/** The part of that number; empty behind the last. */
Blob partOf(Connection& db, int number) {
  Statement row(db, fmt::format("{} WHERE part = {}", schema::select(schema::kIndexColumns, kTable), number));
  if (!row.step()) return {};
  row.skip(1);
  const int written = row.integer();
  Blob data = row.blob();
  if (checksum(data) != written) throw BadCell(fmt::format("part {} is corrupt", number));
  return data;
}

class PartsReader : public std::streambuf {
public:
  PartsReader(Connection& db, std::mutex& mutex) : db_(db), mutex_(mutex) {}

protected:
  int_type underflow() override {
    try {
      const std::lock_guard<std::mutex> lock(mutex_);
      part_ = partOf(db_, number_);
      if (part_.empty() && number_ < number(db_)) throw BadCell(fmt::format("part {} is missing", number_));
      ++number_;
    } catch (const BadCell& e) {
      throw IoError(db_.name(), std::string("is not sound: its place index: ") + e.what());
    }
    if (part_.empty()) return traits_type::eof();
    char* data = reinterpret_cast<char*>(part_.data());
    setg(data, data, data + part_.size());
    return traits_type::to_int_type(*data);
  }

private:
  Connection& db_;
  std::mutex& mutex_;
  Blob part_;
  int number_ = 0;
};

class PartsStream : public std::istream {
public:
  PartsStream(Connection& db, std::mutex& mutex) : std::istream(nullptr), buffer_(db, mutex) {
    rdbuf(&buffer_);
    exceptions(std::ios::badbit);  // passes on the exceptions of underflow()
  }

private:
  PartsReader buffer_;
};

}  // namespace

void write(Connection& db, const std::function<void(std::ostream&)>& writer) {
  remove(db);
  PartsWriter buffer(db);
  std::ostream out(&buffer);
  out.exceptions(std::ios::badbit | std::ios::failbit);
  writer(out);
  buffer.finish();
}

int number(Connection& db) {
  Statement count(db, std::string("SELECT count(*) AS n FROM ") + kTable);
  return count.step() ? count.integer() : 0;
}

void remove(Connection& db) { db.execute(std::string("DELETE FROM ") + kTable); }

std::unique_ptr<std::istream> open(Connection& db, std::mutex& mutex) {
  const std::lock_guard<std::mutex> lock(mutex);
  if (number(db) == 0) return nullptr;
  return std::make_unique<PartsStream>(db, mutex);
}

std::vector<std::string> faults(Connection& db) {
  std::vector<std::string> found;
  const int parts = number(db);
  for (int number = 0; number < parts; ++number) {
    try {
      if (partOf(db, number).empty()) found.push_back("the place index: a part is missing");
    } catch (const BadCell& e) {
      found.push_back(std::string("the place index: ") + e.what());
    }
  }
  return found;
}

}  // namespace facetloc::place_index_parts
