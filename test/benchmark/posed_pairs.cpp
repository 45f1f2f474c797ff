// SPDX-License-Identifier: BSD-3-Clause
#include "posed_pairs.h"

#include "image_overlap.h"

#include <facetloc/features/pose.h>

#include <map>
#include <random>

namespace facetloc::benchmarks {
namespace {

constexpr std::uint32_t kSeed = 1;
constexpr int kAttempts = 200000;

/** Random pairs that pass a test of their poses, then one of their images. */
template <class PoseTest, class ImageTest>
std::vector<FramePair> choose(const std::vector<PosedFrame>& frames, int count, PoseTest&& by_poses,
                              ImageTest&& by_images) {
  std::vector<FramePair> pairs;
  if (frames.empty()) return pairs;
  std::mt19937 random(kSeed);
  std::map<std::size_t, DepthImage> images;
  const auto imageOf = [&](std::size_t i) -> const DepthImage& {
    const auto [it, is_new] = images.try_emplace(i);
    if (is_new) it->second = frames[i].image(kWorkingWidth);
    return it->second;
  };
  for (int attempt = 0; attempt < kAttempts && static_cast<int>(pairs.size()) < count; ++attempt) {
    const std::size_t i = random() % frames.size(), j = random() % frames.size();
    const Eigen::Isometry3d T = trueMotion(frames[i], frames[j]);
    if (by_poses(T) && by_images(imageOf(i), imageOf(j), T)) pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace

std::vector<PosedFrame> posedFrames(const std::vector<DepthSequence>& sequences) {
  std::vector<PosedFrame> frames;
  for (const DepthSequence& sequence : sequences)
    for (std::size_t i = 0; i < sequence.frames().size(); ++i)
      if (const auto T = sequence.groundTruth().at(sequence.frames()[i].stamp))
        frames.push_back({&sequence, i, *T});
  return frames;
}

std::vector<FramePair> relatedPairs(const std::vector<PosedFrame>& frames, const PairChoice& choice) {
  return choose(
      frames, choice.count,
      [&](const Eigen::Isometry3d& T) {
        const double distance = T.translation().norm(), angle_deg = rotationAngle(T.linear()) / kDegree;
        return distance >= choice.min_distance && distance <= choice.max_distance &&
               angle_deg >= choice.min_rotation_deg && angle_deg <= choice.max_rotation_deg;
      },
      [&](const DepthImage& a, const DepthImage& b, const Eigen::Isometry3d& T) {
        return overlap(a, b, T) >= choice.min_overlap && overlap(b, a, T.inverse()) >= choice.min_overlap;
      });
}

std::vector<FramePair> unrelatedPairs(const std::vector<PosedFrame>& frames, const PairChoice& choice) {
  return choose(
      frames, choice.unrelated,
      [&](const Eigen::Isometry3d& T) { return T.translation().norm() >= choice.unrelated_distance; },
      [](const DepthImage& a, const DepthImage& b, const Eigen::Isometry3d& T) {
        return !(overlap(a, b, T) > 0) && !(overlap(b, a, T.inverse()) > 0);
      });
}

}  // namespace facetloc::benchmarks
