// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment_frame_estimation.h>

#include <pcl/impl/pcl_base.hpp>

#include <limits>

namespace facetloc {

template <typename PointT>
void SegmentFrameEstimation<PointT>::compute(PointCloudOut& output) {
  output.clear();
  used_labels_.clear();
  status_.clear();
  if (input_) this->initCompute();  // which complains aloud of none
  const std::optional<Intrinsics> camera = cameraOfInput(input_.get(), indices_.get(), camera_, status_);
  if (!camera) return;
  if (!labels_ || labels_->size() != input_->size()) {
    status_ = "there must be one label per point of the input cloud";
    return;
  }
  LabelImage labels{camera->width, camera->height, std::vector<std::uint16_t>(input_->size(), 0)};
  for (const auto i : *indices_) {
    const std::uint32_t label = (*labels_)[i].label;
    if (label <= std::numeric_limits<std::uint16_t>::max())
      labels.label[i] = static_cast<std::uint16_t>(label);
  }
  this->deinitCompute();
  output = toCloud(estimateSegments(depthImage(*input_, *camera), labels, noise_, params_, &used_labels_));
  output.header = input_->header;
  output.sensor_origin_ = input_->sensor_origin_;
  output.sensor_orientation_ = input_->sensor_orientation_;
  if (output.empty()) status_ = "no label has the support of a segment";
}

}  // namespace facetloc
