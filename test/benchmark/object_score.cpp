// SPDX-License-Identifier: BSD-3-Clause
#include "object_score.h"

#include <algorithm>
#include <map>
#include <stdexcept>

namespace facetloc::benchmarks {

namespace {

constexpr int kObjectStep = 10;   // labels per object
constexpr int kFirstObject = 20;  // label; smaller ones are the table

}  // namespace

ObjectScore& ObjectScore::operator+=(const ObjectScore& other) {
  images += other.images, segments += other.segments, across += other.across;
  segment_pixels += other.segment_pixels, main_pixels += other.main_pixels;
  object_pixels += other.object_pixels, covered_pixels += other.covered_pixels;
  return *this;
}

int objectOf(std::uint16_t label) {
  if (label == 0) return 0;
  return label < kFirstObject ? 1 : label / kObjectStep;
}

ObjectScore objectScore(const LabelImage& found, const Raster<std::uint16_t>& truth,
                        const DepthImage& depth) {
  const std::size_t n = depth.depth.size();
  if (found.label.size() != n || truth.data.size() != n || truth.width != depth.camera.width)
    throw std::invalid_argument("labels and image differ in size");
  ObjectScore score;
  score.images = 1;
  std::map<int, std::map<int, std::size_t>> shared;  // pixels by segment and object
  for (std::size_t i = 0; i < n; ++i) {
    const int object = objectOf(truth.data[i]);
    if (object == 0 || !isMeasured(depth.depth[i])) continue;
    if (object > 1) ++score.object_pixels, score.covered_pixels += found.label[i] != 0;
    if (found.label[i] != 0) ++shared[found.label[i]][object];
  }
  for (const auto& segment : shared) {
    std::size_t all = 0, main = 0;
    for (const auto& [object, pixels] : segment.second) all += pixels, main = std::max(main, pixels);
    if (all < ObjectScore::kMinPixels) continue;
    ++score.segments;
    score.across += static_cast<double>(main) < ObjectScore::kOneObject * static_cast<double>(all);
    score.segment_pixels += all, score.main_pixels += main;
  }
  return score;
}

}  // namespace facetloc::benchmarks
