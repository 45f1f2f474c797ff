// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "recordings/depth_messages.h"
#include "recordings/image_container.h"
#include "recordings/message_file.h"
#include "recordings/recording_layout.h"

#include <facetloc/features/camera_presets.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <tuple>
#include <type_traits>

namespace facetloc::internal {
namespace {

/** Images whose camera is looked for. */
struct ImagesOfTopic {
  std::string topic;                    ///< topic of the plain images
  std::string frame;                    ///< frame of their headers; may be empty
  std::uint32_t width = 0, height = 0;  ///< [px], or 0 if not known
};

constexpr const char* kRealSenseImages = "/image/data";  // ending of the topics of RealSense's recorder

/** /device_0/sensor_0/Depth_0/image/data -> /device_0/sensor_0/option/Depth Units/value. */
void findDepthUnit(const MessageLog& log, CameraFile& camera) {
  for (const MessageTopic& topic : log.topicsOf(FloatMessage::kType)) {
    const std::string name = text::lower(topic.name);
    if (name.find("depth units") == std::string::npos && name.find("depth_units") == std::string::npos)
      continue;
    log.readFirst<FloatMessage>(topic.name, [&camera](const FloatMessage& unit) {
      if (unit.value > 0 && unit.value <= 1) camera.depth_scale = 1 / static_cast<double>(unit.value);
    });
  }
}

/** Images of the size of the sensor are neither binned nor a part of it, whatever the message states. */
CameraInfoMessage infoOf(const ImagesOfTopic& images, const CameraInfoMessage& info) {
  const bool is_whole = images.width == info.width && images.height == info.height;
  return info.isReduced() && !is_whole ? info.ofImage() : info;
}

/** Images called rectified have no lens. */
void take(const CameraInfoMessage& info, bool called_rectified, RecordedCamera& camera) {
  constexpr std::uint32_t kLargestSide = 65535;
  if (info.width > kLargestSide || info.height > kLargestSide) return;
  const int width = static_cast<int>(info.width), height = static_cast<int>(info.height);
  const auto& K = info.K;
  const auto& P = info.P;
  const bool rectified = called_rectified && P[0] > 0;
  camera.file.camera.intrinsics = rectified ? Intrinsics{width, height, P[0], P[5], P[2], P[6]}
                                            : Intrinsics{width, height, K[0], K[4], K[2], K[5]};
  if (rectified) return;
  try {
    camera.file.lens = lensOf(info.distortion_model, info.D);
    if (!camera.file.lens.isNone()) camera.remark = "the lens of its camera_info is taken out of the images";
  } catch (const std::invalid_argument& e) {
    camera.remark = std::string("camera_info: ") + e.what() + "; it is left in the images";
  }
}

/** The topic of another CameraInfo, of the same frame and size; empty if none fits. */
std::string matchingTopic(const MessageLog& log, const ImagesOfTopic& images) {
  if (images.frame.empty() || images.width == 0) return {};
  for (const MessageTopic& topic : log.topicsOf(CameraInfoMessage::kType)) {
    bool matches = false;
    log.readFirst<CameraInfoMessage>(topic.name, [&](const CameraInfoMessage& info) {
      const CameraInfoMessage own = infoOf(images, info);
      matches = info.header.frame == images.frame && own.width == images.width && own.height == images.height;
    });
    if (matches) return topic.name;
  }
  return {};
}

/** Camera by the CameraInfo next to the images, or else by one of the same frame and size; without intrinsics
 * if there is no such message. Its remark is on its source and its lens. RealSense's own recorder also has
 * the unit of depth. Throws IoError for corrupt messages. */
RecordedCamera cameraOfMessages(const MessageLog& log, const ImagesOfTopic& images) {
  const std::string& topic = images.topic;
  const bool is_realsense = endsWith(topic, kRealSenseImages);
  const std::string base = is_realsense
                               ? topic.substr(0, topic.size() - std::strlen(kRealSenseImages)) + "/info"
                               : topic.substr(0, std::min(topic.rfind('/'), topic.size()));
  const CameraPreset& preset = is_realsense ? *findCameraPreset("realsense_d435") : cameraPresets().front();
  RecordedCamera camera{cameraFileOf({}, kMillimetres, preset)};
  if (is_realsense) findDepthUnit(log, camera.file);
  const bool called_rectified = text::lower(topic).find("rect") != std::string::npos;
  const auto use = [&](const CameraInfoMessage& info) {
    const CameraInfoMessage own = infoOf(images, info);
    take(own, called_rectified, camera);
    if (own.width != info.width || own.height != info.height)
      addSentence(
          fmt::format("their camera_info is of {}x{} pixels, of which they are {}x{} by its binning and "
                      "region",
                      info.width, info.height, own.width, own.height),
          camera.remark);
  };
  if (log.readFirst<CameraInfoMessage>(base + "/camera_info", use)) return camera;
  const std::string matching = matchingTopic(log, images);
  if (matching.empty()) return camera;
  log.readFirst<CameraInfoMessage>(matching, use);
  camera.remark = fmt::format("their camera is by {}, which has their frame and size{}{}", matching,
                              camera.remark.empty() ? "" : "; ", camera.remark);
  return camera;
}

/** The topic of the plain images, of which these are. */
std::string baseOf(const std::string& topic) {
  for (const char* transport : {"/compressedDepth", "/compressed"})
    if (endsWith(topic, transport)) return topic.substr(0, topic.size() - std::strlen(transport));
  return topic;
}

class MessageRecording : public ImageContainer {
public:
  MessageRecording(const fs::path& path, const std::string& topic) : log_(path) {
    choose(topic);
    listMessages();
    camera_ = cameraOfMessages(log_, {baseOf(topic_.name), frame_, width_, height_});
  }

  std::size_t size() const override { return messages_.size(); }
  double stamp(std::size_t index) const override { return stamps_.at(index); }
  fs::path path(std::size_t index) const override { return messages_.at(index).file->path(); }
  std::string frame() const override { return frame_; }

  CameraFile camera() const override {
    if (!camera_.file.camera.intrinsics.valid())
      throw IoError(log_.path().string(),
                    fmt::format("has no camera_info for {}; put a camera.ini beside it", topic_.name));
    return camera_.file;
  }

  DepthImage read(std::size_t index) const override {
    const std::string name = fmt::format("{}: image {} of {}", path(index).string(), index, topic_.name);
    DepthImage image;
    const auto use = [&](const auto& message) {
      image = depthImageOf(readDepth(message, name), camera_.file.depth_scale);
    };
    readImage(messages_.at(index), use);
    return image;
  }

  std::string remark() const override {
    std::string words =
        fmt::format("{}: the depth images are those of {}", log_.path().string(), topic_.name);
    if (!others_.empty()) words += fmt::format("; --topic takes others: {}", listOf(others_));
    addSentence(camera_.remark, words);
    if (copies_ > 0) words += fmt::format("; {} more with the time of another left out", copies_);
    if (stray_ > 0) words += fmt::format("; {} written late, sorted by time", stray_);
    addSentence(log_.faults(), words);
    return words;
  }

  ReadGravity gravity(double std) const override { return readImuGravity(log_, frame_, stamps_, std); }

private:
  bool isPlain() const { return topic_.type == ImageMessage::kType; }
  template <typename Use>
  void readImage(const LoggedMessage& message, const Use& use) const {
    isPlain() ? log_.read<ImageMessage>(message, use) : log_.read<CompressedImageMessage>(message, use);
  }

  /** Those whose first message is a depth image. */
  template <typename Message>
  void addDepthTopics(std::vector<MessageTopic>& depth) const {
    for (const MessageTopic& topic : log_.topicsOf(Message::kType))
      log_.readFirst<Message>(topic.name, [&](const Message& message) {
        if (isDepth(message)) depth.push_back(topic);
      });
  }

  void choose(const std::string& wanted) {
    std::vector<MessageTopic> depth;
    addDepthTopics<ImageMessage>(depth);
    addDepthTopics<CompressedImageMessage>(depth);
    const auto rank = [&](const MessageTopic& t) {
      const bool is_named = text::lower(t.name).find("depth") != std::string::npos;
      const bool is_plain = t.type == ImageMessage::kType;
      return std::tuple(t.name != wanted, !is_named, -static_cast<std::int64_t>(t.count), !is_plain, t.name);
    };
    std::sort(depth.begin(), depth.end(),
              [&](const MessageTopic& a, const MessageTopic& b) { return rank(a) < rank(b); });
    if (depth.empty() || (!wanted.empty() && depth.front().name != wanted)) refuse(wanted);
    topic_ = depth.front();
    others_.assign(depth.begin() + 1, depth.end());
  }

  [[noreturn]] void refuse(const std::string& wanted) const {
    std::vector<MessageTopic> images = log_.topicsOf(ImageMessage::kType);
    const auto compressed = log_.topicsOf(CompressedImageMessage::kType);
    images.insert(images.end(), compressed.begin(), compressed.end());
    std::string encodings;
    for (const MessageTopic& topic : images) {
      const auto add = [&](const std::string& encoding) {
        addSentence(fmt::format("{} is of {}", topic.name, encoding), encodings);
      };
      log_.readFirst<ImageMessage>(topic.name, [&](const ImageMessage& image) { add(image.encoding); });
      log_.readFirst<CompressedImageMessage>(topic.name,
                                             [&](const CompressedImageMessage& image) { add(image.format); });
    }
    std::string words = fmt::format("has no depth images{}: {}; its images: {}",
                                    wanted.empty() ? "" : " in " + wanted, kDepthEncodings, listOf(images));
    addSentence(encodings, words);
    if (images.empty()) words += "; its topics: " + listOf(log_.topics());
    addSentence(log_.faults(), words);
    throw IoError(log_.path().string(), words);
  }

  /** The time of an image is the one in its header: when it was taken, not when it was written. */
  void listMessages() {
    std::vector<double> taken, written;
    const auto note = [&](const auto& image) {
      taken.push_back(image.header.stamp);
      if (frame_.empty()) frame_ = image.header.frame;
      if constexpr (std::is_same_v<decltype(image), const ImageMessage&>)
        if (width_ == 0) width_ = image.width, height_ = image.height;
    };
    messages_ = log_.messages(topic_.name, topic_.type);
    for (const LoggedMessage& message : messages_) {
      readImage(message, note);
      written.push_back(message.entry.written);
    }
    if (!isPlain()) findSize();
    if (!putInOrder(taken)) stamps_ = std::move(written);
  }

  /** Sorts the images by the times in their headers, and leaves out copies. False if these are no times: more
   * than a few images are out of their order. */
  bool putInOrder(const std::vector<double>& taken) {
    constexpr double kMostStray = 0.1;  // share of the images
    std::vector<double> ascending;      // ends of the ascending subsequences of each length
    std::map<double, LoggedMessage> of_time;
    for (std::size_t i = 0; i < taken.size(); ++i) of_time.emplace(taken[i], messages_[i]);
    for (const double stamp : taken) {
      const auto end = std::upper_bound(ascending.begin(), ascending.end(), stamp);
      end == ascending.end() ? ascending.push_back(stamp) : void(*end = stamp);
    }
    const double most = std::max(1.0, kMostStray * static_cast<double>(taken.size()));
    const std::size_t stray = taken.size() - ascending.size(), copies = taken.size() - of_time.size();
    const bool is_one_time = of_time.size() == 1 && taken.size() > 1;
    if (is_one_time || static_cast<double>(std::max(stray, copies)) > most) return false;
    stray_ = stray, copies_ = copies;
    messages_.clear();
    for (const auto& [stamp, message] : of_time) {
      stamps_.push_back(stamp);
      messages_.push_back(message);
    }
    return true;
  }

  /** Finds the size of compressed images, which only the images themselves have. */
  void findSize() try {
    log_.read<CompressedImageMessage>(messages_.front(), [&](const CompressedImageMessage& message) {
      const StoredDepth first = readDepth(message, log_.path().string());
      width_ = static_cast<std::uint32_t>(first.width), height_ = static_cast<std::uint32_t>(first.height);
    });
  } catch (const IoError&) {  // told to who loads it
  }

  MessageLog log_;
  MessageTopic topic_;
  std::vector<MessageTopic> others_;  // with depth images
  std::vector<LoggedMessage> messages_;
  std::vector<double> stamps_;
  std::size_t stray_ = 0, copies_ = 0;    // messages out of their order, and copies
  std::string frame_;                     // frame of the images
  std::uint32_t width_ = 0, height_ = 0;  // size of the images, where the messages have it
  RecordedCamera camera_;
};

}  // namespace

std::shared_ptr<const ImageContainer> openMessageRecording(const fs::path& path, const std::string& topic) {
  return std::make_shared<const MessageRecording>(path, topic);
}

}  // namespace facetloc::internal
