// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS 1, by ROS's own library.
#include "recordings/message_file.h"
#include "recordings/ros_messages.h"

#include <facetloc/io/error.h>

#include <fmt/format.h>
#include <mutex>
#include <rosbag/bag.h>
#include <rosbag/view.h>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

class BagFile : public MessageFile {
public:
  explicit BagFile(const fs::path& path) : MessageFile(path) {
    guarded([this] {
      bag_.open(this->path().string(), rosbag::bagmode::Read);
      list();
    });
  }

  Bytes read(const MessageEntry& entry) const override {
    return guarded([&] {
      const std::lock_guard lock(mutex_);
      const rosbag::MessageInstance& message = messages_.at(entry.place);
      if (message.size() > kLargestMessage)
        throw IoError(path().string(), fmt::format("claims a message of {} bytes", message.size()));
      Bytes bytes(message.size());
      ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
      message.write(stream);
      return bytes;
    });
  }

private:
  /** Exceptions of the library become IoErrors. */
  template <typename Work>
  auto guarded(const Work& work) const -> decltype(work()) {
    try {
      return work();
    } catch (const IoError&) {
      throw;
    } catch (const rosbag::BagUnindexedException&) {
      throw IoError(path().string(), "was never finished: its recorder was killed; rosbag reindex mends it");
    } catch (const std::exception& e) {
      throw IoError(path().string(), std::string("cannot be read as a ROS bag: ") + e.what());
    }
  }

  void list() {
    rosbag::View view(bag_);
    for (const rosbag::ConnectionInfo* connection : view.getConnections())
      topicOf(connection->topic, connection->datatype, WireFormat::ros1);
    for (const rosbag::MessageInstance& message : view) {
      const std::size_t topic = topicOf(message.getTopic(), message.getDataType(), WireFormat::ros1);
      const ros::Time time = message.getTime();
      add({topic, time.sec + 1e-9 * time.nsec, messages_.size(), 0});
      if (isKnownType(topics()[topic].type)) messages_.push_back(message);
    }
  }

  rosbag::Bag bag_;
  std::vector<rosbag::MessageInstance> messages_;
  mutable std::mutex mutex_;  // the library reads for one thread at a time
};

}  // namespace

std::unique_ptr<const MessageFile> openRos1Bag(const fs::path& path) {
  return std::make_unique<const BagFile>(path);
}

}  // namespace facetloc::internal
