// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/frame_tree.h"

#include "recordings/message_poses.h"

#include <algorithm>
#include <set>

namespace facetloc::internal {
namespace {

constexpr const char* kOdometryFrame = "odom";

}  // namespace

FrameTree::FrameTree(const MessageLog& log) {
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

bool FrameTree::isFixed(const Edge& edge) const {
  constexpr double kSame = 1e-6;  // [m], and of the entries of rotations
  const std::vector<StampedPose>& poses = transforms_.at(edge);
  return std::all_of(poses.begin(), poses.end(), [&poses](const StampedPose& pose) {
    return (pose.T_w_c.matrix() - poses.front().T_w_c.matrix()).cwiseAbs().maxCoeff() <= kSame;
  });
}

std::optional<Eigen::Isometry3d> FrameTree::fixed(const std::string& a, const std::string& b) const {
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

std::optional<FrameTree::Moving> FrameTree::moving(const std::string& below) const {
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

}  // namespace facetloc::internal
