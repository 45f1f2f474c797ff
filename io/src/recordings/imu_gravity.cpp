// SPDX-License-Identifier: BSD-3-Clause
#include "base/median.h"
#include "recordings/frame_tree.h"
#include "recordings/image_list.h"
#include "recordings/message_poses.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

namespace facetloc::internal {
namespace {

constexpr double kHalfWindow = 0.5;        // [s] longer than a step of who carries the camera
constexpr double kLeastHalfWindow = 0.02;  // [s] at the ends of the recording
constexpr double kMostExcess = 0.2;        // share of the length of gravity

/** An accelerometer whose axes are known. */
struct Imu {
  std::string topic, frame;
  std::size_t count = 0;
  Eigen::Matrix3d R_c_i = Eigen::Matrix3d::Identity();
  const char* how = "";
};

/** Empty if its orientation is unknown. */
std::optional<Imu> turned(Imu imu, const std::string& camera_frame, const FrameTree& tree) {
  constexpr const char* kOptical = "optical_frame";
  if (camera_frame.empty()) return {};
  if (const auto T = tree.fixed(camera_frame, imu.frame)) {
    imu.R_c_i = T->linear();
    imu.how =
        imu.frame == camera_frame ? "which is in the frame of the images" : "which tf has beside the camera";
    return imu;
  }
  if (!endsWith(camera_frame, kOptical) || !endsWith(imu.frame, kOptical)) return {};
  imu.how = "whose frame is called optical, and so turned as the camera's";
  return imu;
}

/** Accelerations of one IMU, and their sums up to each. */
class Accelerations {
public:
  void add(double stamp, const Eigen::Vector3d& a) { samples_.emplace_back(stamp, a); }

  void finish() {
    std::stable_sort(samples_.begin(), samples_.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    sums_.assign(1, Eigen::Vector3d::Zero());
    for (const auto& [stamp, a] : samples_) sums_.push_back(sums_.back() + a);
  }

  /** The mean about a time; the window is as long before as after, so that a turning camera changes nothing.
   */
  std::optional<Eigen::Vector3d> meanAt(double stamp) const {
    if (samples_.empty()) return {};
    const double reach = std::min(stamp - samples_.front().first, samples_.back().first - stamp);
    const double half = std::clamp(reach, kLeastHalfWindow, kHalfWindow);
    const auto before = [](const auto& sample, double t) { return sample.first < t; };
    const auto first = std::lower_bound(samples_.begin(), samples_.end(), stamp - half, before);
    const auto last = std::lower_bound(first, samples_.end(), stamp + half, before);
    if (first == last) return {};
    const auto sum = [this](auto at) { return sums_[static_cast<std::size_t>(at - samples_.begin())]; };
    return Eigen::Vector3d((sum(last) - sum(first)) / static_cast<double>(last - first));
  }

private:
  std::vector<std::pair<double, Eigen::Vector3d>> samples_;
  std::vector<Eigen::Vector3d> sums_;
};

std::vector<StampedGravity> gravityOf(const Accelerations& accelerations, const std::vector<double>& stamps,
                                      const Eigen::Matrix3d& R_c_i, double std) {
  std::vector<std::pair<double, Eigen::Vector3d>> means;
  std::vector<double> lengths;
  for (const double stamp : stamps)
    if (const auto mean = accelerations.meanAt(stamp)) {
      means.emplace_back(stamp, *mean);
      lengths.push_back(mean->norm());
    }
  std::vector<StampedGravity> found;
  if (means.empty()) return found;
  const double g = median(lengths);
  if (!(g > 0)) return found;
  for (const auto& [stamp, mean] : means) {
    const double excess = std::abs(mean.norm() - g) / g;
    if (excess > kMostExcess) continue;
    found.push_back({stamp, gravityAlong(-(R_c_i * mean), std::hypot(std, excess))});
  }
  return found;
}

}  // namespace

ReadGravity readImuGravity(const MessageLog& log, const std::string& camera_frame,
                           const std::vector<double>& stamps, double std) {
  const auto topics = log.topicsOf(ImuMessage::kType);
  if (topics.empty()) return {};
  const FrameTree tree(log);
  std::optional<Imu> best;
  bool measures = false;
  for (const MessageTopic& topic : topics)
    log.readFirst<ImuMessage>(topic.name, [&](const ImuMessage& first) {
      if (!first.has_acceleration) return;
      measures = true;
      const auto imu = turned({topic.name, first.header.frame, topic.count}, camera_frame, tree);
      if (imu && (!best || imu->count > best->count)) best = imu;
    });
  if (!measures) return {};
  if (!best)
    return {{},
            fmt::format("{}: its IMU is not used, since nothing says how it is turned beside the camera "
                        "(frame {})",
                        log.path().string(), camera_frame.empty() ? "without a name" : camera_frame)};
  Accelerations accelerations;
  log.readAll<ImuMessage>(best->topic, [&](const ImuMessage& message) {
    if (message.has_acceleration) accelerations.add(message.header.stamp, message.acceleration);
  });
  accelerations.finish();
  auto samples = gravityOf(accelerations, stamps, best->R_c_i, std);
  if (samples.empty())
    return {{},
            fmt::format("{}: {} has no gravity at the time of any image", log.path().string(), best->topic)};
  std::string remark = fmt::format("{}: gravity is by the accelerometer of {}, {}", log.path().string(),
                                   best->topic, best->how);
  addSentence(tree.faults(), remark);
  return {GravityRecord(std::move(samples)), std::move(remark)};
}

}  // namespace facetloc::internal
