// SPDX-License-Identifier: BSD-3-Clause
#include "base/median.h"
#include "bytes/files.h"
#include "recordings/image_container.h"
#include "recordings/message_file.h"
#include "results/pose_columns.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr const char* kOdometryFrame = "odom";

/** Transforms of a recording: of tf and tf_static. Those that never change are fixed, whoever
 * publishes them. */
class FrameTree {
public:
  /** Reads all transforms, but for those of corrupt messages. */
  explicit FrameTree(const MessageLog& log) {
    for (const MessageTopic& topic : log.topicsOf(TransformsMessage::kType)) {
      const std::string fault =
          log.readSound<TransformsMessage>(topic.name, [&](const TransformsMessage& message) {
            std::vector<StampedPose> poses;
            for (const TransformMessage& t : message.transforms)
              poses.push_back(poseOf(t.header.stamp, t.pose, log.path().string()));
            for (std::size_t i = 0; i < poses.size(); ++i) {
              const TransformMessage& t = message.transforms[i];
              transforms_[{t.header.frame, t.child_frame}].push_back(poses[i]);
            }
          });
      addSentence(fault, faults_);
    }
  }

  /** The messages that were left out; empty if none was. */
  const std::string& faults() const { return faults_; }

  /** T_a_b, by fixed transforms alone; the identity if they are one frame. Nothing if they are not
   * connected. */
  std::optional<Eigen::Isometry3d> fixed(const std::string& a, const std::string& b) const {
    std::map<std::string, Eigen::Isometry3d> reached{{a, Eigen::Isometry3d::Identity()}};  // T_a_x
    for (bool grows = true; grows && reached.count(b) == 0;) {
      grows = false;
      for (const auto& [edge, poses] : transforms_) {
        const auto parent = reached.find(edge.first), child = reached.find(edge.second);
        if ((parent == reached.end()) == (child == reached.end()) || !isFixed(edge)) continue;
        const Eigen::Isometry3d& T = poses.front().T_w_c;
        if (child == reached.end())
          reached.emplace(edge.second, parent->second * T);
        else
          reached.emplace(edge.first, child->second * T.inverse());
        grows = true;
      }
    }
    const auto found = reached.find(b);
    if (found == reached.end()) return {};
    return found->second;
  }

  /** The poses of a frame that moves. */
  struct Moving {
    std::string parent, child;
    std::vector<StampedPose> poses;  ///< T_parent_child
  };
  /** The frame whose parent is `odom`, or else the one frame that moves above another. Empty
   * without one, or with several. \param below the frame that it has to be above, or empty */
  std::optional<Moving> moving(const std::string& below) const {
    for (const auto& [edge, poses] : transforms_)
      if (edge.first == kOdometryFrame) return Moving{edge.first, edge.second, poses};
    std::vector<Edge> found;
    std::set<std::string> seen;
    for (std::string frame = below; seen.insert(frame).second;) {
      const auto above = std::find_if(transforms_.begin(), transforms_.end(),
                                      [&frame](const auto& t) { return t.first.second == frame; });
      if (above == transforms_.end()) break;
      if (!isFixed(above->first)) found.push_back(above->first);
      frame = above->first.first;
    }
    if (found.size() != 1) return {};
    return Moving{found[0].first, found[0].second, transforms_.at(found[0])};
  }

private:
  using Edge = std::pair<std::string, std::string>;  // parent, child
  bool isFixed(const Edge& edge) const {
    constexpr double kSame = 1e-6;  // [m], and of the entries of rotations
    const std::vector<StampedPose>& poses = transforms_.at(edge);
    return std::all_of(poses.begin(), poses.end(), [&poses](const StampedPose& pose) {
      return (pose.T_w_c.matrix() - poses.front().T_w_c.matrix()).cwiseAbs().maxCoeff() <= kSame;
    });
  }

  std::map<Edge, std::vector<StampedPose>> transforms_;
  std::string faults_;
};

/** Poses of one topic. \param remark the number of messages left out is added */
FrameTree::Moving odometryOf(const MessageLog& log, const std::string& topic, std::string& remark) {
  FrameTree::Moving moving;
  const std::string fault = log.readSound<OdometryMessage>(topic, [&](const OdometryMessage& message) {
    moving.poses.push_back(poseOf(message.header.stamp, message.pose, log.path().string()));
    moving.parent = message.header.frame, moving.child = message.child_frame;
  });
  addSentence(fault, remark);
  return moving;
}

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
  using Samples = std::vector<std::pair<double, Eigen::Vector3d>>;

  explicit Accelerations(Samples samples) : samples_(std::move(samples)) {
    std::stable_sort(samples_.begin(), samples_.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
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
  Samples samples_;
  std::vector<Eigen::Vector3d> sums_{Eigen::Vector3d::Zero()};
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

StampedPose poseOf(double stamp, const std::array<double, 7>& columns, const std::string& name) {
  constexpr double kTolerance = 1e-2;  // tolerance of |q|^2
  if (const char* fault = faultOf(columns, kTolerance))
    throw IoError(name, std::string("has a pose that ") + fault);
  return {stamp, fromColumns(columns, kTolerance)};
}

ReadPoses readMessageOdometry(const fs::path& path, const std::string& camera_frame) {
  const MessageLog log(path);
  const auto topics = log.topicsOf(OdometryMessage::kType);
  const FrameTree tree(log);
  std::optional<FrameTree::Moving> moving;
  ReadPoses read;
  if (!topics.empty()) {
    moving = odometryOf(log, topics.front().name, read.remark);  // they are sorted by their names
    if (topics.size() > 1)
      addSentence(fmt::format("{}: the odometry is from {}, the first of {}", path.string(),
                              topics.front().name, listOf(topics)),
                  read.remark);
  } else {
    moving = tree.moving(camera_frame);
  }
  addSentence(tree.faults(), read.remark);
  if (!moving || moving->poses.empty())
    throw IoError(path.string(),
                  "has no odometry: no message nav_msgs/Odometry, and no transform of odom in /tf" +
                      (read.remark.empty() ? "" : "; " + read.remark));
  if (const auto T = camera_frame.empty() ? std::nullopt : tree.fixed(moving->child, camera_frame)) {
    for (StampedPose& pose : moving->poses) pose.T_w_c = pose.T_w_c * *T;
    addSentence(fmt::format("{}: by tf, poses of {} are those of the camera, {}", path.string(),
                            moving->child, camera_frame),
                read.remark);
  }
  read.poses = Trajectory(std::move(moving->poses));
  return read;
}

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
  Accelerations::Samples measured;
  for (const LoggedMessage& logged : log.messages(best->topic, ImuMessage::kType))
    log.read<ImuMessage>(logged, [&measured](const ImuMessage& message) {
      if (message.has_acceleration) measured.emplace_back(message.header.stamp, message.acceleration);
    });
  auto samples = gravityOf(Accelerations(std::move(measured)), stamps, best->R_c_i, std);
  if (samples.empty())
    return {{},
            fmt::format("{}: {} has no gravity at the time of any image", log.path().string(), best->topic)};
  std::string remark = fmt::format("{}: gravity is by the accelerometer of {}, {}", log.path().string(),
                                   best->topic, best->how);
  addSentence(tree.faults(), remark);
  return {GravityRecord(std::move(samples)), std::move(remark)};
}

}  // namespace facetloc::internal
