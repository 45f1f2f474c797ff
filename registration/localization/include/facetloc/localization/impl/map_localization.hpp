// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/localization/map_localization.h>

#include <pcl/impl/pcl_base.hpp>

#include <stdexcept>
#include <utility>

namespace facetloc {

template <typename PointT>
void MapLocalization<PointT>::setMap(std::shared_ptr<const Map> map) {
  map_ = std::move(map);
  builder_.reset();  // the map knows the distortion of its camera
  reset();
}

template <typename PointT>
void MapLocalization<PointT>::setCamera(const Camera& camera) {
  camera_ = camera;
  builder_.reset();
}

template <typename PointT>
void MapLocalization<PointT>::setViewParams(const ViewParams& params) {
  view_params_ = checked(params);
  builder_.reset();
}

template <typename PointT>
void MapLocalization<PointT>::setLocalizationParams(const GlobalLocalizationParams& params) {
  params_ = checked(params);
  reset();
}

template <typename PointT>
void MapLocalization<PointT>::setLocalizerParams(const LocalizerParams& params) {
  localizer_params_ = checked(params);
  reset();
}

template <typename PointT>
void MapLocalization<PointT>::setNumberOfThreads(int n) {
  threads_ = n;
  if (localizer_) localizer_->setNumberOfThreads(n);
}

template <typename PointT>
void MapLocalization<PointT>::setMinProbability(double p) {
  if (!(p > 0 && p <= 1)) throw std::invalid_argument("the least probability must be above 0 and at most 1");
  min_probability_ = p;
  if (localizer_) localizer_->setMinProbability(p);
}

template <typename PointT>
void MapLocalization<PointT>::setSequenceMode(bool on) {
  is_sequence_ = on;
  reset();
}

template <typename PointT>
void MapLocalization<PointT>::reset() {
  localizer_.reset();
  latest_stamp_.reset();
}

/** False, with the reason, for what is no depth image. */
template <typename PointT>
bool MapLocalization<PointT>::see(std::string& why_not) {
  const auto image =
      depthImageOfInput(input_.get(), use_indices_ ? indices_.get() : nullptr, camera_.intrinsics, why_not);
  if (!image) return false;
  if (!builder_) builder_.emplace(map_->calibrated(camera_), view_params_);
  view_ = builder_->build(workingImage(*image, working_width_));
  return true;
}

/** Of the header, if it has one. */
template <typename PointT>
double MapLocalization<PointT>::nextStamp() {
  constexpr double kMicrosecond = 1e-6, kPeriod = 1 / 30.0;  // [s]
  const std::uint64_t stamp = input_ ? input_->header.stamp : 0;
  const double next =
      stamp > 0 ? kMicrosecond * static_cast<double>(stamp) : (latest_stamp_ ? *latest_stamp_ + kPeriod : 0);
  latest_stamp_ = next;
  return next;
}

template <typename PointT>
LocalizerAnswer MapLocalization<PointT>::answer(bool is_image) {
  if (!is_image && !is_sequence_) return {};
  if (!localizer_) {
    localizer_.emplace(map_, localizer_params_, params_);
    localizer_->setNumberOfThreads(threads_);
    if (min_probability_) localizer_->setMinProbability(*min_probability_);
  }
  if (!is_sequence_) return localizer_->localize(view_);
  return localizer_->update(view_, nextStamp());  // a cloud that is none is a camera that saw nothing
}

template <typename PointT>
bool MapLocalization<PointT>::localize(PoseWithCovariance& pose) {
  pose = PoseWithCovariance();
  view_ = View();
  answer_ = {};
  if (!map_) {
    answer_.reason = "there is no map";
    return false;
  }
  std::string why_not;
  const bool is_image = see(why_not);
  answer_ = answer(is_image);
  if (!is_image) answer_.reason = why_not;
  if (answer_.hypotheses.empty()) return false;
  const Hypothesis& best = answer_.hypotheses.front();
  if (!best.T_w_c || !map_->partOf(best.model).empty()) {
    answer_.reason = "the map has no poses in the world: the camera is known in a local model only";
    return false;
  }
  pose = *map_->models[best.model].T_w_m * best.T_m_c;
  pose.T = *best.T_w_c;
  if (answer_.state == AnswerState::sure) return true;
  if (answer_.reason.empty())
    answer_.reason = "doubtful: the most probable of " + std::to_string(answer_.hypotheses.size()) +
                     " places has a probability of " + std::to_string(best.probability);
  return false;
}

template <typename PointT>
bool MapLocalization<PointT>::localize(Eigen::Isometry3d& T_w_c) {
  PoseWithCovariance pose;
  const bool is_sure = localize(pose);
  T_w_c = pose.T;
  return is_sure;
}

}  // namespace facetloc
