// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/message_file.h"
#include "recordings/ros_messages.h"

#include <facetloc/io/error.h>

#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <vector>

/** \file
 * The messages of a recording, whatever files they are in. Private to io. */

namespace facetloc::internal {

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
  /** \brief Faults of files that can be read; empty without faults. */
  std::string faults() const;

  /** \brief Calls use(message) with a message of its type. Throws IoError for a corrupt one. */
  template <typename Message, typename Use>
  void read(const LoggedMessage& logged, const Use& use) const {
    const Bytes bytes = logged.file->read(logged.entry);
    const MessageTopic& topic = logged.file->topics()[logged.entry.topic];
    try {
      MessageReader reader({bytes.data(), bytes.size()}, topic.format);
      use(Message::read(reader));
    } catch (const BadMessage& e) {
      throw IoError(logged.file->path().string(),
                    fmt::format("a message of {} ({}) {}", topic.name, topic.type, e.what()));
    }
  }
  template <typename Message, typename Use>
  void readAll(const std::string& topic, const Use& use) const {
    for (const LoggedMessage& logged : messages(topic, Message::kType)) read<Message>(logged, use);
  }
  /** \brief As readAll(), but messages that cannot be read or used are left out. \return a remark about them:
   * a sentence without full stop, or nothing. \param use may throw IoError, and has done nothing then
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
  std::vector<std::unique_ptr<const MessageFile>> files_;
  std::vector<MessageTopic> topics_;  // topics of all files
};

/** \brief Adds a sentence, behind a semicolon, unless it is empty. */
void addSentence(const std::string& sentence, std::string& sentences);

/** \brief "/odom (12), /pose (3)", or "none". */
std::string listOf(const std::vector<MessageTopic>& topics);

}  // namespace facetloc::internal
