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
  localization_.reset();
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
  localization_.reset();
  reset();
}

template <typename PointT>
void MapLocalization<PointT>::setSequenceParams(const SequenceParams& params) {
  sequence_params_ = checked(params);
  reset();
}

template <typename PointT>
void MapLocalization<PointT>::setNumberOfThreads(int n) {
  threads_ = n;
  if (localization_) localization_->setNumberOfThreads(n);
  if (sequence_) sequence_->setNumberOfThreads(n);
}

template <typename PointT>
void MapLocalization<PointT>::setMinProbability(double p) {
  if (!(p > 0 && p <= 1)) throw std::invalid_argument("the least probability must be above 0 and at most 1");
  min_probability_ = p;
  if (sequence_) sequence_->setMinProbability(p);
}

template <typename PointT>
void MapLocalization<PointT>::setSequenceMode(bool on) {
  is_sequence_ = on;
  reset();
}

template <typename PointT>
void MapLocalization<PointT>::reset() {
  sequence_.reset();
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
void MapLocalization<PointT>::localizeByItself() {
  if (!localization_) {
    localization_.emplace(map_, params_);
    localization_->setNumberOfThreads(threads_);
  }
  Localization answer = localization_->localize(view_);
  state_ = answer.state(min_probability_);
  hypotheses_ = std::move(answer.hypotheses);
  status_ = std::move(answer.reason);
}

template <typename PointT>
void MapLocalization<PointT>::localizeInSequence() {
  if (!sequence_) {
    sequence_.emplace(map_, sequence_params_, params_);
    sequence_->setNumberOfThreads(threads_);
    sequence_->setMinProbability(min_probability_);
  }
  const double stamp = nextStamp();
  SequenceAnswer answer = sequence_->add(view_, stamp);
  state_ = answer.state;
  hypotheses_ = std::move(answer.places);
  status_ = std::move(answer.reason);
}

template <typename PointT>
bool MapLocalization<PointT>::localize(PoseWithCovariance& pose) {
  pose = PoseWithCovariance();
  view_ = View();
  hypotheses_.clear();
  state_ = AnswerState::unknown;
  status_.clear();
  if (!map_) {
    status_ = "there is no map";
    return false;
  }
  std::string why_not;
  const bool is_image = see(why_not);
  if (is_sequence_)
    localizeInSequence();  // a cloud that is none is a camera that saw nothing
  else if (is_image)
    localizeByItself();
  if (!is_image) status_ = why_not;
  if (hypotheses_.empty()) return false;
  const Hypothesis& best = hypotheses_.front();
  if (!best.T_w_c || !map_->partOf(best.model).empty()) {
    status_ = "the map has no poses in the world: the camera is known in a local model only";
    return false;
  }
  pose = *map_->models[best.model].T_w_m * best.T_m_c;
  pose.T = *best.T_w_c;
  if (state_ == AnswerState::sure) return true;
  if (status_.empty())
    status_ = "doubtful: the most probable of " + std::to_string(hypotheses_.size()) +
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
