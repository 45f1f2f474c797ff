// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment_frame_estimation.h>

#include <pcl/impl/pcl_base.hpp>

#include <algorithm>
#include <limits>

namespace facetloc {

template <typename PointT>
void SegmentFrameEstimation<PointT>::compute(PointCloudOut& output) {
  output.clear();
  used_labels_.clear();
  status_.clear();
  if (input_) this->initCompute();  // which complains aloud of none
  std::optional<DepthImage> image = depthImageOfInput(
      input_.get(), this->fake_indices_ ? nullptr : indices_.get(), camera_.intrinsics, status_);
  if (!image) return;
  if (!labels_ || labels_->size() != input_->size()) {
    status_ = "there must be one label per point of the input cloud";
    return;
  }
  std::vector<std::uint32_t> given;  // in their order, which breaks ties
  for (const auto i : *indices_)
    if (isLabel((*labels_)[i].label)) given.push_back((*labels_)[i].label);
  std::sort(given.begin(), given.end());
  given.erase(std::unique(given.begin(), given.end()), given.end());
  if (given.size() > std::numeric_limits<std::uint16_t>::max()) {
    status_ = "there are more than 65535 labels";
    return;
  }
  LabelImage labels{image->camera.width, image->camera.height, std::vector<std::uint16_t>(input_->size(), 0)};
  for (const auto i : *indices_) {
    if (!isLabel((*labels_)[i].label)) continue;
    const auto at = std::lower_bound(given.begin(), given.end(), (*labels_)[i].label);
    labels.label[i] = static_cast<std::uint16_t>(at - given.begin() + 1);
  }
  this->deinitCompute();
  std::vector<int> used;
  dropBeyond(camera_.max_depth, *image);
  output = toCloud(estimateSegments(*image, labels, camera_.noise, params_, &used));
  for (const int label : used) used_labels_.push_back(given[static_cast<std::size_t>(label) - 1]);
  output.header = input_->header;
  output.sensor_origin_ = input_->sensor_origin_;
  output.sensor_orientation_ = input_->sensor_orientation_;
  if (output.empty()) status_ = "no label has the support of a segment";
}

}  // namespace facetloc
