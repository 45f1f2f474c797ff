// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/ranked_registration.h>

#include <algorithm>
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
  if (cloud && !cloud->empty()) return Base::setInputTarget(cloud);
  target_ = pcl::make_shared<typename Base::PointCloudTarget>();
  target_cloud_updated_ = true;
}

template <typename PointT>
void RankedRegistration<PointT>::setIndices(const pcl::IndicesPtr& indices) {
  Base::setIndices(indices);
  rememberIndices();
}
template <typename PointT>
void RankedRegistration<PointT>::setIndices(const pcl::IndicesConstPtr& indices) {
  Base::setIndices(indices);
  rememberIndices();
}
template <typename PointT>
void RankedRegistration<PointT>::setIndices(const pcl::PointIndicesConstPtr& indices) {
  Base::setIndices(indices);
  rememberIndices();
}
template <typename PointT>
void RankedRegistration<PointT>::setIndices(std::size_t row, std::size_t column, std::size_t rows,
                                            std::size_t columns) {
  Base::setIndices(row, column, rows, columns);
  rememberIndices();
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
void RankedRegistration<PointT>::computeTransformation(PointCloudSource& output, const Matrix4& guess) {
  reset("");
  std::string source_fault, target_fault;
  const auto map = std::make_shared<const Map>(mapOf(makeView(*target_, nullptr, target_fault)));
  const View scene = makeView(*input_, use_indices_ ? indices_.get() : nullptr, source_fault);
  if (!indices_fit_) source_fault = "the indices do not fit the cloud";

  PoseWithCovariance prior;
  prior.T.matrix() = guess.template cast<double>();
  prior.T.linear() = Eigen::Quaterniond(prior.T.linear()).normalized().toRotationMatrix();
  prior.P = getPriorCovariance();
  if (!prior.P.allFinite() || !isRigidMotion(guess))
    answer_.reason = "the guess is no rigid motion, or its covariance is not finite";
  else if (!target_fault.empty())
    answer_.reason = "target: " + target_fault;
  else if (!source_fault.empty())
    answer_.reason = "source: " + source_fault;
  else
    answer_ = GlobalLocalization(map, params_).localize(scene, prior);

  const AnswerState state = getState();
  converged_ = state == AnswerState::sure;
  if (state == AnswerState::unknown) {
    status_ = answer_.reason;
    PCL_ERROR("[facetloc::%s::align] %s\n", reg_name_.c_str(), status_.c_str());
    return;
  }
  if (state == AnswerState::doubtful) {
    status_ = "doubtful: the first pose has a probability of " + std::to_string(getProbability());
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
