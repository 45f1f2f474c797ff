// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/image_noise.h>
#include <facetloc/features/region_frame.h>
#include <facetloc/features/segment_frame_estimation.h>

#include <pcl/impl/pcl_base.hpp>

#include <algorithm>
#include <limits>
#include <utility>

namespace facetloc {

template <typename PointT>
void SegmentFrameEstimation<PointT>::compute(PointCloudOut& output) {
  output.clear();
  used_labels_.clear();
  left_out_.clear();
  noise_ = camera_.noise;
  status_.clear();
  if (input_) this->initCompute();  // which complains aloud of none
  const pcl::Indices* chosen = this->fake_indices_ ? nullptr : indices_.get();
  const bool is_organized = input_ && isOrganized(*input_);
  std::optional<DepthImage> image;
  if (!input_ || input_->empty() || is_organized) {
    image = depthImageOfInput(input_.get(), chosen, camera_.intrinsics, status_);
    if (!image) return;
  } else if (chosen && !areIndicesOf(*input_, *chosen)) {
    status_ = "the indices do not fit the cloud";
    return;
  }
  std::vector<std::uint32_t> given;
  if (!readLabels(given)) return;
  const bool has_pixels = image && image->depth.size() == input_->size();
  const std::vector<Segment> segments = has_pixels ? ofImage(std::move(*image), given) : ofRegions(given);
  this->deinitCompute();
  output = toCloud(segments);
  output.header = input_->header;
  output.sensor_origin_ = input_->sensor_origin_;
  output.sensor_orientation_ = input_->sensor_orientation_;
  if (!output.empty()) return;
  status_ = "no label has the support of a segment";
  if (!left_out_.empty()) status_ += ": " + toString(left_out_, given.size());
}

/** The labels in their order, which breaks ties. */
template <typename PointT>
bool SegmentFrameEstimation<PointT>::readLabels(std::vector<std::uint32_t>& given) {
  if (!labels_ || labels_->size() != input_->size()) {
    status_ = "there must be one label per point of the input cloud";
    return false;
  }
  for (const auto i : *indices_)
    if (isLabel((*labels_)[i].label)) given.push_back((*labels_)[i].label);
  std::sort(given.begin(), given.end());
  given.erase(std::unique(given.begin(), given.end()), given.end());
  if (given.size() <= std::numeric_limits<std::uint16_t>::max()) return true;
  status_ = "there are more than 65535 labels";
  return false;
}

template <typename PointT>
std::vector<Segment> SegmentFrameEstimation<PointT>::ofImage(DepthImage image,
                                                             const std::vector<std::uint32_t>& given) {
  LabelImage labels{image.camera.width, image.camera.height, std::vector<std::uint16_t>(input_->size(), 0)};
  for (const auto i : *indices_) {
    if (!isLabel((*labels_)[i].label)) continue;
    const auto at = std::lower_bound(given.begin(), given.end(), (*labels_)[i].label);
    labels.label[i] = static_cast<std::uint16_t>(at - given.begin() + 1);
  }
  dropBeyond(camera_.max_depth, image);
  noise_ = measuredNoise(image, camera_.noise);
  std::vector<int> used;
  std::vector<LeftOutRegion> left_out;
  std::vector<Segment> segments = estimateSegments(image, labels, noise_, params_, &used, &left_out);
  const auto labelOf = [&given](int number) { return given[static_cast<std::size_t>(number) - 1]; };
  for (const int label : used) used_labels_.push_back(labelOf(label));
  for (const LeftOutRegion& region : left_out) left_out_.push_back({labelOf(region.label), region.reason});
  return segments;
}

template <typename PointT>
std::vector<Segment> SegmentFrameEstimation<PointT>::ofRegions(const std::vector<std::uint32_t>& given) {
  std::vector<std::vector<Eigen::Vector3d>> regions(given.size());
  for (const auto i : *indices_) {
    if (!isLabel((*labels_)[i].label)) continue;
    const auto at = std::lower_bound(given.begin(), given.end(), (*labels_)[i].label);
    regions[static_cast<std::size_t>(at - given.begin())].push_back(
        (*input_)[i].getVector3fMap().template cast<double>());
  }
  std::vector<Segment> found;
  std::vector<std::uint32_t> labels;
  for (std::size_t k = 0; k < regions.size(); ++k) {
    const auto segment = regionSegment(regions[k], viewpoint_.template cast<double>(), noise_, params_);
    const bool is_large = segment && segment->num_points >= params_.min_support;
    if (is_large)
      found.push_back(*segment), labels.push_back(given[k]);
    else
      left_out_.push_back(
          {given[k], segment ? "is too small" : "is no plane of some width, seen from the viewpoint"});
  }
  std::vector<Segment> ranked;
  for (const int k : rankByInformation(found)) {
    ranked.push_back(found[static_cast<std::size_t>(k)]);
    used_labels_.push_back(labels[static_cast<std::size_t>(k)]);
  }
  return ranked;
}

}  // namespace facetloc
