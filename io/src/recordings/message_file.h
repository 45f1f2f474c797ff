// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/message_reader.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

/** \file
 * Files of recorded messages: the common parts of a bag of ROS 1, a database of rosbag2 and an MCAP. Private
 * to io. */

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
  void addFault(const std::string& words);

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
/** \brief The file, or the files of a folder of rosbag2: those that its metadata.yaml lists, or else all.
 * Throws IoError for a folder without any. */
std::vector<std::filesystem::path> messageFilesOf(const std::filesystem::path& path);

}  // namespace facetloc::internal
