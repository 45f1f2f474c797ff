// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/files.h"
#include "recordings/ros_messages.h"

#include <facetloc/io/error.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <vector>

/** \file
 * Recorded messages: the common parts of a bag of ROS 1, a database of rosbag2 and an MCAP, and a recording
 * of such files. Private to io. */

namespace facetloc::internal {

/** \brief Messages of one name and type. */
struct MessageTopic {
  std::string name;
  std::string type;  ///< as "sensor_msgs/Image", of ROS 2 as well
  WireFormat format = WireFormat::other;
  std::size_t count = 0;  ///< number of all messages
};

/** \brief Where a message is. */
struct MessageEntry {
  std::size_t topic = 0;    ///< index of its topic
  double written = 0;       ///< when it was recorded [s]
  std::uint64_t place = 0;  ///< as its file counts
  std::uint64_t inner = 0;  ///< within that place, if the file needs it
};

/** \brief The largest message, and the largest chunk of messages, that is believed [bytes]. */
constexpr std::uint64_t kLargestMessage = 1ull << 27;

/** \brief A file that is open to be read. */
class MessageFile {
public:
  virtual ~MessageFile() = default;

  const std::filesystem::path& path() const { return path_; }
  const std::vector<MessageTopic>& topics() const { return topics_; }
  /** \brief Messages of the types that are read here (isKnownType), in the order in which they were written.
   */
  const std::vector<MessageEntry>& entries() const { return entries_; }
  /** \brief A fault of a file that can be read, a clause such as "was never finished"; or
   * empty. */
  const std::string& fault() const { return fault_; }

  /** \brief The bytes of a message. Thread-safe. Throws IoError. */
  virtual Bytes read(const MessageEntry& entry) const = 0;

protected:
  explicit MessageFile(std::filesystem::path path) : path_(std::move(path)) {}
  /** \brief The index of such a topic, which is made if it is new. */
  std::size_t topicOf(const std::string& name, const std::string& type, WireFormat format);
  /** \brief Counts a message, and lists it if it may be asked for. */
  void add(const MessageEntry& entry);
  void sortEntries();
  void addFault(const std::string& words) { addSentence(words, fault_); }

private:
  std::filesystem::path path_;
  std::vector<MessageTopic> topics_;
  std::vector<bool> known_;  // indexed by topic: may its messages be requested?
  std::vector<MessageEntry> entries_;
  std::string fault_;
};

/** \brief Opens a file by its name: .bag, .db3 or .mcap. Throws IoError. */
std::unique_ptr<const MessageFile> openMessageFile(const std::filesystem::path& path);

/** \brief Each throws IoError if the file is none of its kind. */
std::unique_ptr<const MessageFile> openRos1Bag(const std::filesystem::path& path);
std::unique_ptr<const MessageFile> openRosbag2Database(const std::filesystem::path& path);
std::unique_ptr<const MessageFile> openMcap(const std::filesystem::path& path);

/** \brief Is it one, by its name, or a folder of rosbag2 with several? */
bool isMessageRecording(const std::filesystem::path& path);

/** \brief A message that is not read yet. */
struct LoggedMessage {
  const MessageFile* file = nullptr;
  MessageEntry entry;
};

/** \brief A recording of messages: a bag, a database of rosbag2, an MCAP, or a folder of several of these.
 * Reading is thread-safe. */
class MessageLog {
public:
  /** \brief Throws IoError. */
  explicit MessageLog(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  const std::vector<MessageTopic>& topics() const { return topics_; }
  /** \brief The topics of a type that can be read. */
  std::vector<MessageTopic> topicsOf(const std::string& type) const;
  /** \brief Messages of a topic with that name and type, by the time when they were recorded. */
  std::vector<LoggedMessage> messages(const std::string& topic, const std::string& type) const;
  /** \brief Faults of files that can be read, or of their list; empty without faults. */
  std::string faults() const;

  /** \brief Calls use(message) with a message of its type. Throws IoError for a corrupt one. */
  template <typename Message, typename Use>
  void read(const LoggedMessage& logged, const Use& use) const {
    const Bytes bytes = logged.file->read(logged.entry);
    const MessageTopic& topic = logged.file->topics()[logged.entry.topic];
    try {
      MessageReader reader(bytes, topic.format);
      use(Message::read(reader));
    } catch (const BadMessage& e) {
      throw IoError(logged.file->path().string(),
                    fmt::format("a message of {} ({}) {}", topic.name, topic.type, e.what()));
    }
  }
  /** \brief Calls use(message) with all messages of a topic, but for those that cannot be read or used.
   * \return a remark about them: a sentence without full stop, or nothing. \param use may throw IoError, and
   * has done nothing then
   */
  template <typename Message, typename Use>
  std::string readSound(const std::string& topic, const Use& use) const {
    const std::vector<LoggedMessage> all = messages(topic, Message::kType);
    std::size_t left_out = 0;
    std::string why;
    for (const LoggedMessage& logged : all) try {
        read<Message>(logged, use);
      } catch (const IoError& e) {
        if (left_out++ == 0) why = e.what();
      }
    if (left_out == 0) return {};
    return fmt::format("{} of {} messages of {} left out, such as {}", left_out, all.size(), topic, why);
  }
  /** \brief The first message of a topic, if there is one. \return was there? */
  template <typename Message, typename Use>
  bool readFirst(const std::string& topic, const Use& use) const {
    const auto all = messages(topic, Message::kType);
    if (!all.empty()) read<Message>(all.front(), use);
    return !all.empty();
  }

private:
  std::filesystem::path path_;
  std::string remark_;  // on files that are not as metadata.yaml lists them; or nothing
  std::vector<std::unique_ptr<const MessageFile>> files_;
  std::vector<MessageTopic> topics_;  // topics of all files
};

/** \brief "/odom (12), /pose (3)", or "none". */
std::string listOf(const std::vector<MessageTopic>& topics);

// Compressed bytes. The size that they claim is not trusted: memory grows with the unpacked data.

/** \brief Does it begin as a frame of Zstandard does? */
bool isZstd(ByteView packed);

/** \brief Unpacks Zstandard frames. Throws IoError if they are corrupt, end early or unpack to more than
 * `most` bytes. \param name of the file, in errors */
Bytes unpackZstd(ByteView packed, std::uint64_t most, const std::string& name);

/** \brief Unpacks up to `most` bytes: of a torn chunk, the bytes in front of the tear.
 * \param compression of a chunk: empty, zstd, lz4 or bz2. Throws IoError for others. */
Bytes unpackedChunk(ByteView packed, const std::string& compression, std::uint64_t most,
                    const std::string& name);

}  // namespace facetloc::internal
