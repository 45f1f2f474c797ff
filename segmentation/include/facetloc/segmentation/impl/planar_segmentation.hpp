// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/segmentation/planar_segmentation.h>

#include <pcl/impl/pcl_base.hpp>

#include <cmath>

namespace facetloc {

template <typename PointT>
bool PlanarSegmentation<PointT>::compute() {
  status_.clear();
  if (input_) this->initCompute();  // which complains aloud of none
  std::optional<DepthImage> image = depthImageOfInput(
      input_.get(), this->fake_indices_ ? nullptr : indices_.get(), camera_.intrinsics, status_);
  if (!image) {
    result_ = {};
    return false;
  }
  this->deinitCompute();
  dropBeyond(camera_.max_depth, *image);
  if (!segmenter_) segmenter_.emplace(params_, camera_.noise);
  segmenter_->segment(*image, result_);
  if (result_.planes.empty()) status_ = "no planar segment of the minimum support";
  return true;
}

/** 0 for points that were not measured, and that a nearer one hides. */
template <typename PointT>
int PlanarSegmentation<PointT>::labelOf(std::size_t point) const {
  const PointT& p = (*input_)[point];
  if (isOrganized(*input_) && result_.labels.label.size() == input_->size())
    return std::isfinite(p.z) ? result_.labels.label[point] : 0;
  const auto pixel = pixelOf(p, result_.camera);
  if (!pixel) return 0;
  constexpr double kHidden = 0.02;  // share of depth
  const int label = result_.labels.label[*pixel];
  if (label == 0) return 0;
  const Eigen::Vector2d q = result_.camera.project({p.x, p.y, p.z});
  const double inverse = result_.planes[static_cast<std::size_t>(label) - 1].at(q.x(), q.y());
  return std::abs(1 - inverse * p.z) <= kHidden ? label : 0;
}

template <typename PointT>
void PlanarSegmentation<PointT>::segment(std::vector<pcl::PointIndices>& segments) {
  segments.clear();
  if (!compute()) return;
  segments.resize(result_.planes.size());
  for (std::size_t k = 0; k < segments.size(); ++k) {
    segments[k].header = input_->header;
    segments[k].indices.reserve(result_.support[k]);
  }
  for (const auto i : *indices_)
    if (const int k = labelOf(static_cast<std::size_t>(i)); k > 0) segments[k - 1].indices.push_back(i);
}

template <typename PointT>
void PlanarSegmentation<PointT>::segment(std::vector<pcl::PointIndices>& segments,
                                         std::vector<pcl::ModelCoefficients>& coefficients) {
  segment(segments);
  coefficients.assign(segments.size(), {});
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const Eigen::Vector3d m = result_.planes[k].toSpace(result_.camera);  // m . p = 1
    const double length = m.norm();
    coefficients[k].header = input_->header;
    coefficients[k].values = {static_cast<float>(-m.x() / length), static_cast<float>(-m.y() / length),
                              static_cast<float>(-m.z() / length), static_cast<float>(1 / length)};
  }
}

template <typename PointT>
void PlanarSegmentation<PointT>::segment(Labels& labels) {
  labels.clear();
  if (!compute()) return;
  labels.header = input_->header;
  labels.resize(input_->size());
  labels.width = input_->width;
  labels.height = input_->height;
  const auto set = [&](std::size_t i) { labels[i].label = static_cast<std::uint32_t>(labelOf(i)); };
  for (const auto i : *indices_) set(static_cast<std::size_t>(i));
}

}  // namespace facetloc
