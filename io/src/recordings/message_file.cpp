// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/message_file.h"

#include "bytes/yaml_entries.h"
#include "recordings/image_list.h"

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr const char* kMetadata = "metadata.yaml";

struct Kind {
  const char* extension;
  std::unique_ptr<const MessageFile> (*open)(const fs::path& path);
};
constexpr Kind kKinds[] = {{".bag", openRos1Bag}, {".db3", openRosbag2Database}, {".mcap", openMcap}};

const Kind* kindOf(const fs::path& path) {
  const std::string extension = lowerExtension(path);
  const auto* kind = std::find_if(std::begin(kKinds), std::end(kKinds),
                                  [&extension](const Kind& k) { return extension == k.extension; });
  return kind == std::end(kKinds) ? nullptr : kind;
}

std::vector<fs::path> filesIn(const fs::path& folder) {
  return files::entriesOf(folder,
                          [](const auto& entry) { return kindOf(entry.path()) && files::isFile(entry); });
}

bool isRosbag2(const fs::path& folder) {
  const fs::path metadata = folder / kMetadata;
  return files::isFile(metadata) &&
         files::readText(metadata).find("rosbag2_bagfile_information") != std::string::npos;
}

/** The names below relative_file_paths; without the folders that some versions put in front. */
std::vector<fs::path> listedIn(const fs::path& metadata) {
  std::vector<fs::path> listed;
  for (const YamlEntry& entry : yamlEntries(files::readText(metadata)))
    if (entry.key == "relative_file_paths")
      for (const std::string& name : entry.words)
        listed.push_back(metadata.parent_path() / fs::path(name).filename());
  return listed;
}

/** The file itself; of a folder, those that its metadata.yaml lists, or else all that are there, with a
 * remark. */
std::vector<fs::path> messageFilesOf(const fs::path& path, std::string& remark) {
  if (!files::isFolder(path)) return {path};
  const bool has_list = isRosbag2(path);
  const std::vector<fs::path> listed = has_list ? listedIn(path / kMetadata) : std::vector<fs::path>();
  std::string missing;
  for (const fs::path& file : listed) {
    if (!kindOf(file))
      throw IoError(file.string(),
                    "is listed in metadata.yaml and of a kind that is not read; a file that is "
                    "compressed as a whole has to be unpacked first: zstd -d");
    if (!files::isThere(file)) missing += (missing.empty() ? "" : ", ") + file.filename().string();
  }
  if (!listed.empty() && missing.empty()) return listed;
  std::vector<fs::path> there = filesIn(path);
  const auto isOfRos1 = [](const fs::path& file) { return lowerExtension(file) == ".bag"; };
  if (has_list || !std::all_of(there.begin(), there.end(), isOfRos1))
    remark = fmt::format("{}: {}: the files of messages that are there are read ({}); 'ros2 bag reindex {}' "
                         "lists them",
                         path.string(),
                         !has_list         ? "has no metadata.yaml"
                         : missing.empty() ? "its metadata.yaml lists no files"
                                           : "its metadata.yaml names files that are not there, " + missing,
                         there.size(), path.string());
  return there;
}

/** The index of the topic of that name, type and format, which is added if it is new. */
std::size_t indexOf(const MessageTopic& topic, std::vector<MessageTopic>& topics) {
  const auto same = std::find_if(topics.begin(), topics.end(), [&topic](const MessageTopic& t) {
    return t.name == topic.name && t.type == topic.type && t.format == topic.format;
  });
  const auto index = static_cast<std::size_t>(same - topics.begin());
  if (same == topics.end()) topics.push_back({topic.name, topic.type, topic.format, 0});
  return index;
}

}  // namespace

std::size_t MessageFile::topicOf(const std::string& name, const std::string& type, WireFormat format) {
  const std::size_t index = indexOf({name, type, format, 0}, topics_);
  if (index == known_.size()) known_.push_back(isKnownType(type));
  return index;
}

void MessageFile::add(const MessageEntry& entry) {
  ++topics_.at(entry.topic).count;
  if (known_[entry.topic]) entries_.push_back(entry);
}

void MessageFile::sortEntries() {
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const MessageEntry& a, const MessageEntry& b) { return a.written < b.written; });
}

std::unique_ptr<const MessageFile> openMessageFile(const fs::path& path) {
  files::requireRegularFile(path);
  if (const Kind* kind = kindOf(path)) return kind->open(path);
  throw IoError(path.string(),
                "is not a recording of messages: its name ends with none of .bag, .db3 and .mcap");
}

bool isMessageRecording(const fs::path& path) {
  if (!files::isFolder(path)) return kindOf(path) != nullptr;
  if (isRosbag2(path)) return true;
  return !filesIn(path).empty() && imagesOfFolder(folderOfImages(path)).empty();
}

MessageLog::MessageLog(const fs::path& path) : path_(path) {
  for (const fs::path& file : messageFilesOf(path, remark_)) files_.push_back(openMessageFile(file));
  if (files_.empty())
    throw IoError(path.string(), "has no recording of messages (.bag, .db3 or .mcap) in it" +
                                     (remark_.empty() ? "" : "; " + remark_));
  for (const auto& file : files_)
    for (const MessageTopic& topic : file->topics()) topics_[indexOf(topic, topics_)].count += topic.count;
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
  std::string words = remark_;
  for (const auto& file : files_)
    if (!file->fault().empty())
      addSentence(fmt::format("{}: {}", file->path().string(), file->fault()), words);
  return words;
}

std::string listOf(const std::vector<MessageTopic>& topics) {
  std::string list;
  for (const MessageTopic& topic : topics)
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", topic.name, topic.count);
  return list.empty() ? "none" : list;
}

}  // namespace facetloc::internal
