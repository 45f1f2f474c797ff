// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/bag.h"

#include "files.h"
#include "plausible.h"
#include "pose_columns.h"
#include "recordings/calibration_file.h"
#include "recordings/image_list.h"
#include "shared/text.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <mutex>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/Float32.h>
#include <tf2_msgs/TFMessage.h>
#include <vector>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRealSenseImages = "/image/data";  // ending of the topics of RealSense's recorder
constexpr const char* kOdometryFrame = "odom";
constexpr double kMillimetres = 1000;  // PNG values per metre
constexpr double kTolerance = 1e-2;    // of |q|^2

double secondsOf(const ros::Time& time) { return time.sec + 1e-9 * time.nsec; }

std::string lower(std::string s) {
  for (char& c : s) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return s;
}

/** A bag that is open to be read. What its library throws becomes an IoError. */
class Bag {
public:
  explicit Bag(const fs::path& path) : path_(path.string()) {
    files::requireRegularFile(path);
    guarded([this] { bag_.open(path_, rosbag::bagmode::Read); });
  }

  template <typename Work>
  auto guarded(const Work& work) const -> decltype(work()) {
    try {
      return work();
    } catch (const IoError&) {
      throw;
    } catch (const rosbag::BagUnindexedException&) {
      throw IoError(path_, "was never finished: its recorder was killed; rosbag reindex mends it");
    } catch (const std::exception& e) {
      throw IoError(path_, std::string("cannot be read as a ROS bag: ") + e.what());
    }
  }

  /** Topics with messages of a type, and how many. */
  std::map<std::string, std::size_t> topicsOf(const std::string& type) const {
    std::map<std::string, std::size_t> topics;
    rosbag::View view(bag_, rosbag::TypeQuery(type));
    for (const rosbag::ConnectionInfo* connection : view.getConnections()) topics[connection->topic] = 0;
    for (auto& [topic, count] : topics) count = rosbag::View(bag_, rosbag::TopicQuery(topic)).size();
    return topics;
  }

  /** The first message of a topic; null if there is none of this type. */
  template <typename Message>
  boost::shared_ptr<Message> first(const std::string& topic) const {
    rosbag::View view(bag_, rosbag::TopicQuery(topic));
    return view.begin() == view.end() ? nullptr : view.begin()->instantiate<Message>();
  }

  template <typename Message>
  void forEach(const std::string& topic, const std::function<void(const Message&)>& use) const {
    rosbag::View view(bag_, rosbag::TopicQuery(topic));
    for (const rosbag::MessageInstance& instance : view)
      if (const auto message = instance.instantiate<Message>()) use(*message);
  }

  const std::string& path() const { return path_; }
  const rosbag::Bag& bag() const { return bag_; }

private:
  std::string path_;
  rosbag::Bag bag_;
};

/** Bytes of a pixel; 0 if it is no depth. */
std::size_t pixelSize(const std::string& encoding) {
  if (encoding == "16UC1" || encoding == "mono16") return sizeof(std::uint16_t);
  return encoding == "32FC1" ? sizeof(float) : 0;
}

std::string listOf(const std::map<std::string, std::size_t>& topics) {
  std::string list;
  for (const auto& [topic, count] : topics)
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", topic, count);
  return list.empty() ? "none" : list;
}

class BagContainer : public ImageContainer {
public:
  BagContainer(const fs::path& path, const std::string& topic) : bag_(path) {
    bag_.guarded([&] {
      choose(topic);
      listMessages();
      findCamera();
    });
  }

  std::size_t size() const override { return messages_.size(); }
  double stamp(std::size_t index) const override { return stamps_.at(index); }

  CameraFile camera() const override {
    if (!camera_.camera.intrinsics.valid())
      throw IoError(bag_.path(),
                    fmt::format("has no camera_info for {}; a camera.ini beside it would say it", topic_));
    return camera_;
  }

  DepthImage read(std::size_t index) const override {
    return bag_.guarded([&] {
      const std::lock_guard lock(mutex_);
      const auto message = messages_.at(index).instantiate<sensor_msgs::Image>();
      if (!message) throw IoError(bag_.path(), fmt::format("image {} is of another type", index));
      return depthOf(*message, index);
    });
  }

  std::string remark() const override {
    std::string words = fmt::format("{}: the depth images are those of {}", bag_.path(), topic_);
    if (others_ > 0) words += fmt::format(", one of {} topics with such images", others_ + 1);
    if (!lens_remark_.empty()) words += "; " + lens_remark_;
    return words;
  }

private:
  void choose(const std::string& wanted) {
    const auto images = bag_.topicsOf("sensor_msgs/Image");
    std::vector<std::pair<std::string, std::size_t>> depth;
    for (const auto& [topic, count] : images) {
      const auto message = bag_.first<sensor_msgs::Image>(topic);
      if (message && pixelSize(message->encoding) > 0) depth.emplace_back(topic, count);
    }
    const auto rank = [&](const std::pair<std::string, std::size_t>& t) {
      const bool is_named = lower(t.first).find("depth") != std::string::npos;
      return std::tuple(t.first != wanted, !is_named, -static_cast<std::int64_t>(t.second), t.first);
    };
    const auto best = std::min_element(depth.begin(), depth.end(),
                                       [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
    if (best == depth.end() || (!wanted.empty() && best->first != wanted))
      throw IoError(
          bag_.path(),
          fmt::format("has no depth images{} (sensor_msgs/Image of 16UC1, mono16 or 32FC1); its images: {}",
                      wanted.empty() ? "" : " in " + wanted, listOf(images)));
    topic_ = best->first;
    others_ = depth.size() - 1;
  }

  /** The time of an image is the one in its header: when it was taken, not when it was written. */
  void listMessages() {
    rosbag::View view(bag_.bag(), rosbag::TopicQuery(topic_));
    std::vector<std::uint8_t> bytes;
    std::vector<double> taken, written;
    for (const rosbag::MessageInstance& message : view) {
      bytes.resize(message.size());
      ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
      message.write(stream);
      std::array<std::uint32_t, 3> header{};  // number, seconds, nanoseconds
      if (bytes.size() < sizeof header) throw IoError(bag_.path(), "has an image without a header");
      std::memcpy(header.data(), bytes.data(), sizeof header);
      taken.push_back(header[1] + 1e-9 * header[2]);
      written.push_back(secondsOf(message.getTime()));
      messages_.push_back(message);
    }
    const bool ascending =
        std::adjacent_find(taken.begin(), taken.end(), std::greater_equal<>()) == taken.end();
    stamps_ = ascending ? std::move(taken) : std::move(written);
  }

  void findCamera() {
    const bool is_realsense = endsWith(topic_, kRealSenseImages);
    const std::string base = is_realsense
                                 ? topic_.substr(0, topic_.size() - std::strlen(kRealSenseImages)) + "/info"
                                 : topic_.substr(0, topic_.rfind('/'));
    const CameraPreset& preset = is_realsense ? *findCameraPreset("realsense_d435") : cameraPresets().front();
    camera_.camera = preset.camera();
    camera_.preset = preset.name;
    camera_.depth_scale = kMillimetres;
    if (is_realsense) findDepthUnit();
    if (const auto info = bag_.first<sensor_msgs::CameraInfo>(base + "/camera_info")) {
      const bool rectified = lower(topic_).find("rect") != std::string::npos && info->P[0] > 0;
      const auto& K = info->K;
      const auto& P = info->P;
      const int width = static_cast<int>(info->width), height = static_cast<int>(info->height);
      camera_.camera.intrinsics = rectified ? Intrinsics{width, height, P[0], P[5], P[2], P[6]}
                                            : Intrinsics{width, height, K[0], K[4], K[2], K[5]};
      if (!rectified) findLens(info->distortion_model, {info->D.begin(), info->D.end()});
    }
  }

  /** Images called rectified have none. */
  void findLens(const std::string& model, const std::vector<double>& coefficients) {
    try {
      camera_.lens = lensOf(model, coefficients);
      if (!camera_.lens.isNone()) lens_remark_ = "the lens of its camera_info is taken out of the images";
    } catch (const std::invalid_argument& e) {
      lens_remark_ = std::string("camera_info: ") + e.what() + "; it is left in the images";
    }
  }

  /** /device_0/sensor_0/Depth_0/image/data -> /device_0/sensor_0/option/Depth Units/value. */
  void findDepthUnit() {
    for (const auto& [topic, count] : bag_.topicsOf("std_msgs/Float32")) {
      const std::string name = lower(topic);
      if (name.find("depth units") == std::string::npos && name.find("depth_units") == std::string::npos)
        continue;
      const auto unit = bag_.first<std_msgs::Float32>(topic);
      if (unit && unit->data > 0 && unit->data <= 1)
        camera_.depth_scale = 1 / static_cast<double>(unit->data);
    }
  }

  DepthImage depthOf(const sensor_msgs::Image& message, std::size_t index) const {
    constexpr std::uint32_t kLargestSide = 65535;
    const std::size_t pixel = pixelSize(message.encoding), row = message.width * pixel;
    const auto fail = [&](const std::string& cause) {
      throw IoError(bag_.path(), fmt::format("image {} of {} {}", index, topic_, cause));
    };
    if (pixel == 0) fail("is of the encoding " + text::quoted(message.encoding));
    if (message.is_bigendian) fail("is big-endian");
    if (message.width == 0 || message.height == 0 || message.width > kLargestSide ||
        message.height > kLargestSide || message.step < row ||
        message.data.size() < std::size_t(message.step) * message.height)
      fail("is corrupt");
    DepthImage image;
    image.camera.width = static_cast<int>(message.width);
    image.camera.height = static_cast<int>(message.height);
    image.depth.reserve(std::size_t(message.width) * message.height);
    for (std::uint32_t v = 0; v < message.height; ++v)
      for (std::uint32_t u = 0; u < message.width; ++u) {
        const std::uint8_t* bytes = message.data.data() + std::size_t(v) * message.step + u * pixel;
        image.depth.push_back(pixel == sizeof(float) ? metres(bytes) : scaled(bytes));
      }
    return image;
  }

  static float metres(const std::uint8_t* bytes) {
    float z = 0;
    std::memcpy(&z, bytes, sizeof z);
    return std::isfinite(z) && z > 0 ? z : 0;
  }
  float scaled(const std::uint8_t* bytes) const {
    std::uint16_t value = 0;
    std::memcpy(&value, bytes, sizeof value);
    return value == std::numeric_limits<std::uint16_t>::max()
               ? 0
               : static_cast<float>(value / camera_.depth_scale);
  }

  Bag bag_;
  mutable std::mutex mutex_;  // the library reads for one thread at a time
  std::string topic_;
  std::size_t others_ = 0;  // topics with depth images
  std::vector<rosbag::MessageInstance> messages_;
  std::vector<double> stamps_;
  CameraFile camera_;
  std::string lens_remark_;
};

template <typename Position, typename Orientation>
StampedPose poseOf(const ros::Time& time, const Position& t, const Orientation& q, const std::string& path) {
  const PoseColumns columns = {t.x, t.y, t.z, q.x, q.y, q.z, q.w};
  const auto T = fromColumns(columns, kTolerance);
  if (!T) throw IoError(path, std::string("has a pose that ") + faultOf(columns, kTolerance));
  return {secondsOf(time), *T};
}

}  // namespace

std::shared_ptr<const ImageContainer> openBag(const fs::path& path, const std::string& topic) {
  return std::make_shared<const BagContainer>(path, topic);
}

Trajectory readBagOdometry(const fs::path& path) {
  const Bag bag(path);
  std::vector<StampedPose> poses;
  bag.guarded([&] {
    const auto odometry = bag.topicsOf("nav_msgs/Odometry");
    if (!odometry.empty())
      bag.forEach<nav_msgs::Odometry>(odometry.begin()->first, [&](const nav_msgs::Odometry& m) {
        poses.push_back(poseOf(m.header.stamp, m.pose.pose.position, m.pose.pose.orientation, bag.path()));
      });
    else
      for (const char* topic : {"/tf", "tf"})
        bag.forEach<tf2_msgs::TFMessage>(topic, [&](const tf2_msgs::TFMessage& m) {
          for (const auto& t : m.transforms)
            if (t.header.frame_id == kOdometryFrame || t.header.frame_id == std::string("/") + kOdometryFrame)
              poses.push_back(
                  poseOf(t.header.stamp, t.transform.translation, t.transform.rotation, bag.path()));
        });
  });
  if (poses.empty())
    throw IoError(path.string(),
                  "has no odometry: no message nav_msgs/Odometry, and no transform of odom in /tf");
  return Trajectory(std::move(poses));
}

}  // namespace facetloc::internal
