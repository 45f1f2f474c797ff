// SPDX-License-Identifier: BSD-3-Clause
// Databases of rosbag2: one table of topics, one of messages.
#include "bytes/sqlite.h"
#include "recordings/message_file.h"
#include "recordings/ros_messages.h"

#include <fmt/format.h>
#include <map>
#include <mutex>

namespace facetloc::internal {
namespace {

class Rosbag2Database : public MessageFile {
public:
  explicit Rosbag2Database(const fs::path& path) : MessageFile(path), db_(path, SQLITE_OPEN_READONLY) {
    guarded([this] {
      listTopics();
      listMessages();
    });
    sortEntries();
  }

  Bytes read(const MessageEntry& entry) const override {
    return guarded([&] {
      const std::lock_guard lock(mutex_);
      sqlite::Statement row(db_, fmt::format("SELECT data FROM messages WHERE rowid = {}", entry.place));
      if (!row.step()) throw sqlite::BadCell("a message has been deleted since the file was opened");
      Bytes data = row.blob();
      return isZstd(data)  // rosbag2's separate compression of each message
                 ? unpackZstd(data, kLargestMessage, path().string())
                 : data;
    });
  }

private:
  template <typename Work>
  auto guarded(const Work& work) const -> decltype(work()) {
    return sqlite::naming(path().string(), "is no sound recording of rosbag2: ", work);
  }

  void listTopics() {
    try {
      sqlite::Statement row(db_, "SELECT id, name, type, serialization_format FROM topics ORDER BY id");
      while (row.step()) {
        const int id = row.integer();
        const std::string name = row.text(), type = typeWithoutMsg(row.text());
        topic_of_[id] = topicOf(name, type, row.text() == "cdr" ? WireFormat::cdr : WireFormat::other);
      }
    } catch (const IoError&) {
      if ((db_.lastCode() & 0xFF) != SQLITE_ERROR) throw;
      throw IoError(path().string(), "is no recording of rosbag2: it has no table of topics");
    }
  }

  /** Lists messages in the order of the rows, so that a torn file is listed as far as it goes. */
  void listMessages() {
    try {
      sqlite::Statement row(db_, "SELECT rowid, topic_id, timestamp FROM messages ORDER BY rowid");
      while (row.step()) {
        const auto id = row.large();
        const auto topic = topic_of_.find(row.integer());
        const double written = kNanosecond * static_cast<double>(row.large());
        if (topic == topic_of_.end()) throw sqlite::BadCell("a message is of a topic that is not listed");
        add({topic->second, written, static_cast<std::uint64_t>(id), 0});
      }
    } catch (const IoError&) {
      if ((db_.lastCode() & 0xFF) != SQLITE_CORRUPT || entries().empty()) throw;
      addFault("is truncated or damaged: it is read as far as it goes");
    }
  }

  mutable sqlite::Connection db_;
  mutable std::mutex mutex_;  // a connection is for one thread at a time
  std::map<int, std::size_t> topic_of_;
};

}  // namespace

std::unique_ptr<const MessageFile> openRosbag2Database(const fs::path& path) {
  return std::make_unique<const Rosbag2Database>(path);
}

}  // namespace facetloc::internal
