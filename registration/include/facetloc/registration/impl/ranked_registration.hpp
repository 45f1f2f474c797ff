// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/ranked_registration.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace facetloc {

/** \brief Is it a turn and a move, as well as floats tell? */
inline bool isRigidMotion(const Eigen::Matrix4f& T) {
  constexpr float kTolerance = 1e-3f;
  const Eigen::Matrix3f R = T.topLeftCorner<3, 3>();
  return T.allFinite() && (R.transpose() * R).isIdentity(kTolerance) && R.determinant() > 0 &&
         T.row(3) == Eigen::RowVector4f(0, 0, 0, 1);
}

template <typename PointT>
RankedRegistration<PointT>::RankedRegistration() {
  this->setSearchMethodTarget(pcl::make_shared<LazyKdTree<PointT>>());
  reset("not aligned yet");
}

template <typename PointT>
void RankedRegistration<PointT>::setInputSource(const PointCloudSourceConstPtr& cloud) {
  reset("not aligned yet");
  if (cloud && !cloud->empty())
    Base::setInputSource(cloud);
  else
    input_ = pcl::make_shared<PointCloudSource>();  // PCL would keep the old cloud and align that
  applyIndices();
}

template <typename PointT>
void RankedRegistration<PointT>::setInputTarget(const PointCloudTargetConstPtr& cloud) {
  reset("not aligned yet");
  forgetTarget();
  if (cloud && !cloud->empty()) return Base::setInputTarget(cloud);
  target_ = pcl::make_shared<typename Base::PointCloudTarget>();
  target_cloud_updated_ = true;
}

template <typename PointT>
void RankedRegistration<PointT>::rememberIndices() {
  chosen_ = indices_;
  applyIndices();
}

// PCL's align() copies the points before computeTransformation() could look at their indices, and makes some
// for all points if there are none, which would stay when another cloud is set.
template <typename PointT>
void RankedRegistration<PointT>::applyIndices() {
  indices_ = chosen_;
  use_indices_ = chosen_ != nullptr;
  fake_indices_ = false;
  indices_fit_ = true;
  if (!chosen_ || !input_) return;
  const auto size = static_cast<std::int64_t>(input_->size());
  const auto fits = [size](auto i) { return 0 <= i && i < size; };
  if (std::all_of(chosen_->begin(), chosen_->end(), fits)) return;
  indices_ = pcl::make_shared<pcl::Indices>();
  indices_fit_ = size == 0;  // an empty cloud is a fault of its own
}

template <typename PointT>
Eigen::Isometry3d RankedRegistration<PointT>::getFinalPose() const {
  return answer_.hypotheses.empty() ? Eigen::Isometry3d::Identity() : answer_.hypotheses.front().T_m_c.T;
}

template <typename PointT>
double RankedRegistration<PointT>::getProbability() const {
  return answer_.hypotheses.empty() || !answer_.has_probabilities ? 0
                                                                  : answer_.hypotheses.front().probability;
}

template <typename PointT>
Matrix6d RankedRegistration<PointT>::getFinalCovariance() const {
  return answer_.hypotheses.empty() ? Matrix6d(Matrix6d::Zero()) : answer_.hypotheses.front().T_m_c.P;
}

template <typename PointT>
double RankedRegistration<PointT>::getFitnessScore(double max_range) {
  constexpr std::size_t kSampled = 10000;
  constexpr double kNone = std::numeric_limits<double>::max();
  if (!input_) return kNone;
  const std::size_t step = (input_->size() / kSampled) | 1;  // odd, so that rows are met at all columns
  PointCloudSource sample;
  for (std::size_t i = 0; i < input_->size(); i += step) sample.push_back((*input_)[i]);
  double sum = 0;
  std::size_t n = 0;
  pcl::Indices nearest(1);
  std::vector<float> squared_distance(1);
  for (PointT& p : sample) {
    if (!pcl::isXYZFinite(p)) continue;
    p.getVector3fMap() = (final_transformation_ * p.getVector3fMap().homogeneous()).template head<3>();
    this->tree_->nearestKSearch(p, 1, nearest, squared_distance);
    if (!(squared_distance[0] <= max_range)) continue;  // PCL compares the square, too
    sum += squared_distance[0];
    ++n;
  }
  return n > 0 && std::isfinite(sum) ? sum / static_cast<double>(n) : kNone;
}

template <typename PointT>
void RankedRegistration<PointT>::readTarget() {
  if (in_target_) return;
  target_fault_.clear();
  in_target_ = std::make_shared<const PairRegistration>(makeView(*target_, nullptr, target_fault_), params_);
}

// The distance of a correspondence, between two planes: of a point of one from the other.
template <typename PointT>
std::optional<std::vector<SegmentPair>>
RankedRegistration<PointT>::nearPairs(const View& scene, const View& target, const PoseWithCovariance& guess,
                                      std::optional<std::vector<SegmentPair>> pairs) const {
  if (!(corr_dist_threshold_ < std::sqrt(std::numeric_limits<double>::max()))) return pairs;  // never set
  if (!pairs) pairs = candidatePairs(scene.segments, target.segments, guess, params_.matching);
  const auto isTooFar = [&](const SegmentPair& p) {
    const Segment& model = target.segments[static_cast<std::size_t>(p.model)];
    const Eigen::Vector3d moved = guess.T * scene.segments[static_cast<std::size_t>(p.scene)].t;
    return !(std::abs(model.normal().dot(moved - model.t)) <= corr_dist_threshold_);
  };
  pairs->erase(std::remove_if(pairs->begin(), pairs->end(), isTooFar), pairs->end());
  return pairs;
}

// Small surfaces that a finer view shows fit by chance more often.
template <typename PointT>
Localization RankedRegistration<PointT>::alignFiner(const PoseWithCovariance& prior) {
  constexpr double kDoubt = 2.3;  // odds of ten to one [nats]
  if (!in_finer_target_) {
    std::optional<View> target = makeFinerView(*target_, nullptr);
    if (!target) return {};
    in_finer_target_ = std::make_shared<const PairRegistration>(std::move(*target), params_);
  }
  const std::optional<View> scene = makeFinerView(*input_, use_indices_ ? indices_.get() : nullptr);
  if (!scene) return {};
  const auto pairs = nearPairs(*scene, in_finer_target_->target(), prior, std::nullopt);
  return in_finer_target_->align(*scene, prior, pairs ? &*pairs : nullptr, kDoubt);
}

template <typename PointT>
Localization RankedRegistration<PointT>::registered(const View& scene, const PoseWithCovariance& prior) {
  Localization answer;
  const auto isSure = [&] { return answer.stateAt(min_probability_) == AnswerState::sure; };
  const bool chooses =
      takesCorrespondences() && (correspondence_estimation_ || !correspondence_rejectors_.empty());
  const auto pairs =
      nearPairs(scene, in_target_->target(), prior, chooses ? choosePairs(prior) : std::nullopt);
  if (pairs && pairs->empty()) {
    answer.reason = "no correspondence of source and target is left";
    return answer;
  }
  answer = in_target_->align(scene, prior, pairs ? &*pairs : nullptr);
  if (isSure() || chooses) return answer;
  if (Localization finer = alignFiner(prior); !finer.hypotheses.empty()) answer = std::move(finer);
  if (isSure() || pairs || prior_covariance_ || !prior.T.matrix().isIdentity()) return answer;
  if (Localization turned = in_target_->alignTurned(scene, prior);
      turned.stateAt(min_probability_) == AnswerState::sure)
    answer = std::move(turned);
  return answer;
}

template <typename PointT>
void RankedRegistration<PointT>::warnOfSetters() {
  const bool is_set = this->max_iterations_ != unset_iterations_ || this->ransac_iterations_ != 0 ||
                      this->transformation_epsilon_ != 0 || this->transformation_rotation_epsilon_ != 0 ||
                      this->euclidean_fitness_epsilon_ != std::numeric_limits<double>::lowest() ||
                      this->transformation_estimation_ != nullptr;
  if (!is_set || has_warned_) return;
  has_warned_ = true;
  PCL_WARN("[facetloc::%s::align] iterations, epsilons and estimators of transformations have no effect; the "
           "limits of the search are set by setRegistrationParams()\n",
           reg_name_.c_str());
}

template <typename PointT>
void RankedRegistration<PointT>::computeTransformation(PointCloudSource& output, const Matrix4& guess) {
  reset("");
  warnOfSetters();
  std::string source_fault;
  readTarget();
  const View scene = makeView(*input_, use_indices_ ? indices_.get() : nullptr, source_fault);
  if (!indices_fit_) source_fault = "the indices do not fit the cloud";

  PoseWithCovariance prior;
  prior.T.matrix() = guess.template cast<double>();
  prior.T.linear() = Eigen::Quaterniond(prior.T.linear()).normalized().toRotationMatrix();
  prior.P = getPriorCovariance();
  if (!prior.P.allFinite() || !isRigidMotion(guess))
    answer_.reason = "the guess is no rigid motion, or its covariance is not finite";
  else if (!target_fault_.empty())
    answer_.reason = "target: " + target_fault_;
  else if (!source_fault.empty())
    answer_.reason = "source: " + source_fault;
  else if (!takesCorrespondences() && (correspondence_estimation_ || !correspondence_rejectors_.empty()))
    answer_.reason =
        "estimations and rejectors of correspondences choose pairs of segment frames: use EkfRegistration";
  else
    answer_ = registered(scene, prior);

  const AnswerState state = getState();
  converged_ = state == AnswerState::sure;
  if (state == AnswerState::unknown) {
    status_ =
        answer_.hypotheses.empty() ? answer_.reason : "unknown: the clouds more likely show different places";
    PCL_ERROR("[facetloc::%s::align] %s\n", reg_name_.c_str(), status_.c_str());
  }
  if (answer_.hypotheses.empty()) return;
  if (state == AnswerState::doubtful) {
    status_ = "doubtful: the first pose has a probability of " + std::to_string(getProbability());
    if (!answer_.reason.empty()) status_ += "; " + answer_.reason;
    PCL_WARN("[facetloc::%s::align] %s\n", reg_name_.c_str(), status_.c_str());
  }
  nr_iterations_ = 1;
  const Eigen::Isometry3d T = getFinalPose();
  transformation_ = final_transformation_ = T.matrix().template cast<float>();
  for (PointT& p : output) transformPoint(T, p);
}

template <typename PointT>
void RankedRegistration<PointT>::reset(const std::string& reason) {
  converged_ = false;
  final_transformation_ = transformation_ = Matrix4::Identity();
  nr_iterations_ = 0;
  answer_ = {};
  status_ = reason;
}

}  // namespace facetloc
