// SPDX-License-Identifier: BSD-3-Clause
#include "relabel.h"

#include <facetloc/segmentation/view_builder.h>

#include <chrono>
#include <cmath>
#include <stdexcept>

namespace facetloc {

using namespace internal;
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

SegmentEstimationParams featuresOf(const ViewParams& params) {
  SegmentEstimationParams features = params.features;
  features.min_support = params.labels.min_support;
  return features;
}

}  // namespace

ViewBuilder::ViewBuilder(const Camera& camera, const ViewParams& params, int working_width)
    : camera_(std::make_shared<const Camera>(camera)),
      segmenter_(checked(params), checked(camera.noise)),
      estimation_(featuresOf(params)),
      working_width_(working_width) {
  if (!(camera.max_depth > 0)) throw std::invalid_argument("ViewBuilder: max_depth must be positive");
  if (camera.distortion) correction_.emplace(*camera.distortion);
}

View ViewBuilder::build(const DepthImage& image, const std::optional<Gravity>& gravity) {
  View view;
  build(image, view);
  view.gravity = gravity;
  return view;
}

void ViewBuilder::build(const DepthImage& measured, View& view) {
  const Clock::time_point start = Clock::now();
  const DepthImage& image = prepared(measured);
  segmenter_.segment(image, segmentation_);
  segment_ms_ = millisecondsSince(start);

  const Clock::time_point features_start = Clock::now();
  SensorNoise noise = camera_->noise;
  noise.correlation_px = segmentation_.correlation_px;
  static_cast<DepthNoise&>(noise) = noise.scaledTo(segmentation_.noise, usualDepth(image));
  view.camera = camera_;
  view.intrinsics = image.camera;
  estimation_.estimate(image, segmentation_.labels, noise, view.segments, kept_);
  view.depth.assign(image);
  view.depth.noise = noise;
  renumber();
  features_ms_ = millisecondsSince(features_start);
}

// At the working width, without the depths that the camera does not measure, or not well, and without its
// distortion.
const DepthImage& ViewBuilder::prepared(const DepthImage& full) {
  const bool is_large = working_width_ > 0 && subsamplingStep(full.camera, working_width_) > 1;
  if (is_large) small_ = workingImage(full, working_width_);
  const DepthImage& measured = is_large ? small_ : full;
  if (std::isinf(camera_->max_depth)) return correction_ ? (*correction_)(measured) : measured;
  near_ = measured;
  dropBeyond(camera_->max_depth, near_);
  return correction_ ? (*correction_)(near_) : near_;
}

// Label kept_[i] becomes i + 1, all others 0; planes and supports follow.
void ViewBuilder::renumber() {
  LabelledPlanes& s = segmentation_;
  unsorted_.planes.swap(s.planes);
  unsorted_.support.swap(s.support);
  s.planes.clear();
  s.support.clear();
  new_label_.assign(unsorted_.planes.size() + 1, 0);
  for (const int label : kept_) {
    s.planes.push_back(unsorted_.planes[label - 1]);
    s.support.push_back(unsorted_.support[label - 1]);
    new_label_[label] = static_cast<std::uint16_t>(s.planes.size());
  }
  relabel(s.labels.label, new_label_);
}

}  // namespace facetloc
