// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/localization/map_localization.h>
#include <facetloc/segmentation/impl/view_builder.hpp>

#include <pcl/impl/pcl_base.hpp>

#include <algorithm>
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
void MapLocalization<PointT>::reset() {
  localizer_.reset();
  latest_stamp_.reset();
  motion_.reset();
  is_motion_lost_ = false;
}

template <typename PointT>
void MapLocalization<PointT>::addMotion(const Eigen::Isometry3d& T_before_now) {
  addMotion(motionByOdometry(T_before_now, camera_.mounting, odometry_error_));
}

template <typename PointT>
void MapLocalization<PointT>::addMotion(const PoseWithCovariance& T_before_now) {
  if (!T_before_now.T.matrix().allFinite() || !T_before_now.P.allFinite()) is_motion_lost_ = true;
  motion_ = motion_ ? *motion_ * T_before_now : T_before_now;
}

template <typename PointT>
std::string MapLocalization<PointT>::getPart() const {
  return answer_.hypotheses.empty() || !map_ ? std::string() : map_->partOf(answer_.hypotheses.front().model);
}

/** False, with the reason, for a cloud that is no depth image. */
template <typename PointT>
bool MapLocalization<PointT>::see(std::string& why_not) {
  if (!builder_) builder_.emplace(map_->calibrated(camera_), view_params_, working_width_);
  const auto view = builder_->build(input_.get(), use_indices_ ? indices_.get() : nullptr, why_not, gravity_);
  if (view) view_ = *view;
  return view.has_value();
}

/** Stamp of the header, if it has one; else one period after the latest. */
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
Localizer& MapLocalization<PointT>::localizer() {
  if (!localizer_) {
    localizer_.emplace(map_, localizer_params_, params_);
    localizer_->setNumberOfThreads(threads_);
    if (min_probability_) localizer_->setMinProbability(*min_probability_);
  }
  return *localizer_;
}

/** The answer for the view, be it an image or the next of a drive. */
template <typename PointT>
Localization MapLocalization<PointT>::answer(const std::optional<PoseWithCovariance>& guess,
                                             const std::string& part) {
  if (guess) {
    Localization refused;
    const auto found = std::find(map_->parts.begin(), map_->parts.end(), part);
    if (found == map_->parts.end() && !(map_->parts.empty() && part.empty())) {
      refused.reason = "the map has no part '" + part + "'";
      return refused;
    }
    const int number = static_cast<int>(found - map_->parts.begin());
    try {
      if (!is_sequence_) return localizer().localize(view_, *guess, number);
      localizer().setPose(*guess, number);
    } catch (const std::invalid_argument& e) {
      refused.reason = std::string("the guess cannot be used: ") + e.what();
      return refused;
    }
  }
  if (!is_sequence_) return localizer().localize(view_);
  const std::optional<PoseWithCovariance> motion = is_motion_lost_ ? std::nullopt : motion_;
  motion_.reset();
  is_motion_lost_ = false;
  return localizer().update(view_, nextStamp(), motion);  // an invalid cloud counts as a view of nothing
}

template <typename PointT>
bool MapLocalization<PointT>::localizeNear(const std::optional<PoseWithCovariance>& guess,
                                           const std::string& part, PoseWithCovariance& pose) {
  pose = PoseWithCovariance();
  view_ = View();
  answer_ = {};
  if (!map_) {
    answer_.reason = "there is no map";
    return false;
  }
  std::string why_not;
  const bool is_image = see(why_not);
  if (is_image || is_sequence_) answer_ = answer(guess, part);
  if (!is_image) answer_.reason = why_not;
  if (answer_.hypotheses.empty()) return false;
  const Hypothesis& best = answer_.hypotheses.front();
  const std::optional<Eigen::Isometry3d>& T_w_m = map_->models[best.model].T_w_m;
  pose = T_w_m ? *T_w_m * best.T_m_c : best.T_m_c;
  if (best.T_w_c) pose.T = *best.T_w_c;
  if (answer_.state == AnswerState::sure) return true;
  if (answer_.reason.empty())
    answer_.reason = "doubtful: the most probable of " + std::to_string(answer_.hypotheses.size()) +
                     " places has a probability of " + std::to_string(best.probability);
  return false;
}

template <typename PointT>
bool MapLocalization<PointT>::localize(PoseWithCovariance& pose) {
  return localizeNear({}, {}, pose);
}

template <typename PointT>
bool MapLocalization<PointT>::localize(PoseWithCovariance& pose, const PoseWithCovariance& guess,
                                       const std::string& part) {
  return localizeNear(std::optional(guess), part, pose);  // a copy: the result may be the same pose
}

template <typename PointT>
bool MapLocalization<PointT>::localize(Eigen::Isometry3d& T_w_c) {
  PoseWithCovariance pose;
  const bool is_sure = localize(pose);
  T_w_c = pose.T;
  return is_sure;
}

}  // namespace facetloc
