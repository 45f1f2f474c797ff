// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/message_log.h"

#include <algorithm>

namespace facetloc::internal {

MessageLog::MessageLog(const std::filesystem::path& path) : path_(path) {
  for (const std::filesystem::path& file : messageFilesOf(path)) files_.push_back(openMessageFile(file));
  if (files_.empty())
    throw IoError(path.string(), "has no recording of messages (.bag, .db3 or .mcap) in it");
  for (const auto& file : files_)
    for (const MessageTopic& topic : file->topics()) {
      const auto same = std::find_if(topics_.begin(), topics_.end(), [&topic](const MessageTopic& t) {
        return t.name == topic.name && t.type == topic.type && t.format == topic.format;
      });
      if (same == topics_.end())
        topics_.push_back(topic);
      else
        same->count += topic.count;
    }
  std::sort(topics_.begin(), topics_.end(),
            [](const MessageTopic& a, const MessageTopic& b) { return a.name < b.name; });
}

std::vector<MessageTopic> MessageLog::topicsOf(const std::string& type) const {
  std::vector<MessageTopic> found;
  std::copy_if(topics_.begin(), topics_.end(), std::back_inserter(found),
               [&type](const MessageTopic& t) { return t.type == type && t.format != WireFormat::other; });
  return found;
}

std::vector<LoggedMessage> MessageLog::messages(const std::string& topic, const std::string& type) const {
  std::vector<LoggedMessage> found;
  for (const auto& file : files_)
    for (const MessageEntry& entry : file->entries()) {
      const MessageTopic& t = file->topics()[entry.topic];
      if (t.name == topic && t.type == type && t.format != WireFormat::other)
        found.push_back({file.get(), entry});
    }
  std::stable_sort(found.begin(), found.end(), [](const LoggedMessage& a, const LoggedMessage& b) {
    return a.entry.written < b.entry.written;
  });
  return found;
}

std::string MessageLog::faults() const {
  std::string words;
  for (const auto& file : files_)
    if (!file->fault().empty())
      addSentence(fmt::format("{}: {}", file->path().string(), file->fault()), words);
  return words;
}

void addSentence(const std::string& sentence, std::string& sentences) {
  if (!sentence.empty()) sentences += (sentences.empty() ? "" : "; ") + sentence;
}

std::string listOf(const std::vector<MessageTopic>& topics) {
  std::string list;
  for (const MessageTopic& topic : topics)
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", topic.name, topic.count);
  return list.empty() ? "none" : list;
}

}  // namespace facetloc::internal
