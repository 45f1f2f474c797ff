// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/segmentation/view_builder.h>

#include <chrono>

namespace facetloc {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Label kept[i] becomes i + 1, all others 0; planes and supports follow.
void renumber(const std::vector<int>& kept, LabelledPlanes& s) {
  std::vector<std::uint16_t> new_label(s.planes.size() + 1, 0);
  std::vector<PixelPlane> planes;
  std::vector<int> support;
  for (const int label : kept) {
    planes.push_back(s.planes[label - 1]);
    support.push_back(s.support[label - 1]);
    new_label[label] = static_cast<std::uint16_t>(planes.size());
  }
  for (std::uint16_t& label : s.labels.label) label = new_label[label];
  s.planes.swap(planes);
  s.support.swap(support);
}

}  // namespace

ViewBuilder::ViewBuilder(const ViewParams& params)
    : params_(params), segmenter_(params.segmentation, params.noise) {}

View ViewBuilder::build(const DepthImage& image) {
  const Clock::time_point start = Clock::now();
  segmenter_.segment(image, segmentation_);
  segment_ms_ = millisecondsSince(start);

  const Clock::time_point features_start = Clock::now();
  SensorNoise noise = params_.noise;
  noise.inverse_depth_std = segmentation_.noise;
  View view;
  view.camera = image.camera;
  std::vector<int> kept;
  view.segments = estimateSegments(image, segmentation_.labels, noise, params_.features, &kept);
  view.depth = DepthPicture::fromDepth(image);
  renumber(kept, segmentation_);
  features_ms_ = millisecondsSince(features_start);
  return view;
}

}  // namespace facetloc
