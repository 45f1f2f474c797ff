// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>
#include <facetloc/io/depth_sequence.h>

#include <Eigen/Geometry>

#include <string>
#include <utility>
#include <vector>

namespace facetloc::benchmarks {

/** \brief An image of a recording and its true pose. Images are read when they are needed. */
struct PosedFrame {
  const DepthSequence* sequence;
  std::size_t index;
  Eigen::Isometry3d T_w_c;

  const std::string& name() const { return sequence->frames()[index].name; }
  DepthImage image(int working_width) const { return sequence->load(index, working_width); }
};

/** \brief All frames with a true pose. The sequences must outlive them. */
std::vector<PosedFrame> posedFrames(const std::vector<DepthSequence>& sequences);

/** \brief Which pairs of images are compared. */
struct PairChoice {
  static constexpr const char* kTitle = "Pairs of images, by their true poses";
  int count = 40;
  double min_distance = 0.6, max_distance = 1.7, min_rotation_deg = 20, max_rotation_deg = 60;
  double min_overlap = 0.3;
  int unrelated = 60;
  double unrelated_distance = 4;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("count", p.count, 1, 100000, "Number of related pairs.");
    visit("min_distance", p.min_distance, 0.0, 100.0, "Least distance of the cameras [m].");
    visit("max_distance", p.max_distance, 0.0, 100.0, "Largest distance of the cameras [m].");
    visit("min_rotation_deg", p.min_rotation_deg, 0.0, 180.0, "Least angle between the cameras.");
    visit("max_rotation_deg", p.max_rotation_deg, 0.0, 180.0, "Largest angle between the cameras.");
    visit("min_overlap", p.min_overlap, 0.0, 1.0, "Least share of either image that the other shows.");
    visit("unrelated", p.unrelated, 0, 100000, "Number of unrelated pairs.");
    visit("unrelated_distance", p.unrelated_distance, 0.0, 100.0,
          "Least distance of the cameras of unrelated pairs, without a pixel in common [m].");
  }
};

/** \brief Two frames, by their places in the list. */
using FramePair = std::pair<std::size_t, std::size_t>;

/** \brief Pairs of the same place, by a fixed seed; fewer if there are no more. */
std::vector<FramePair> relatedPairs(const std::vector<PosedFrame>& frames, const PairChoice& choice);
/** \brief Pairs that are far apart and share no pixel. */
std::vector<FramePair> unrelatedPairs(const std::vector<PosedFrame>& frames, const PairChoice& choice);

/** \brief T_target_source by the true poses. */
inline Eigen::Isometry3d trueMotion(const PosedFrame& source, const PosedFrame& target) {
  return target.T_w_c.inverse() * source.T_w_c;
}

}  // namespace facetloc::benchmarks
