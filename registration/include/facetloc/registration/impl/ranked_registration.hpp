// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/ranked_registration.h>

namespace facetloc {

template <typename PointT>
RankedRegistration<PointT>::RankedRegistration() {
  this->setSearchMethodTarget(pcl::make_shared<LazyKdTree<PointT>>());
  reset("not aligned yet");
}

template <typename PointT>
void RankedRegistration<PointT>::setInputSource(const PointCloudSourceConstPtr& cloud) {
  reset("not aligned yet");
  if (cloud && !cloud->empty()) return Base::setInputSource(cloud);
  input_.reset();  // PCL would keep the old cloud and align that
  reset("the source cloud is missing or empty");
}

template <typename PointT>
void RankedRegistration<PointT>::setInputTarget(const PointCloudTargetConstPtr& cloud) {
  reset("not aligned yet");
  if (cloud && !cloud->empty()) return Base::setInputTarget(cloud);
  target_.reset();
  reset("the target cloud is missing or empty");
}

template <typename PointT>
Eigen::Isometry3d RankedRegistration<PointT>::getFinalPose() const {
  return answer_.hypotheses.empty() ? Eigen::Isometry3d::Identity() : answer_.hypotheses.front().T_m_c.T;
}

template <typename PointT>
Matrix6d RankedRegistration<PointT>::getFinalCovariance() const {
  return answer_.hypotheses.empty() ? Matrix6d(Matrix6d::Zero()) : answer_.hypotheses.front().T_m_c.P;
}

template <typename PointT>
void RankedRegistration<PointT>::computeTransformation(PointCloudSource& output, const Matrix4& guess) {
  reset("");
  auto map = std::make_shared<Map>();
  map->models.resize(1);
  map->models[0].T_w_m = Eigen::Isometry3d::Identity();
  std::string source_fault, target_fault;
  map->models[0].view = makeView(*target_, nullptr, target_fault);
  const View scene = makeView(*input_, use_indices_ ? indices_.get() : nullptr, source_fault);

  PoseWithCovariance prior;
  prior.T.matrix() = guess.template cast<double>();
  prior.T.linear() = Eigen::Quaterniond(prior.T.linear()).normalized().toRotationMatrix();
  prior.P = getPriorCovariance();
  if (!prior.T.matrix().allFinite() || !prior.P.allFinite())
    answer_.reason = "the guess or its covariance is not finite";
  else if (!target_fault.empty())
    answer_.reason = "target: " + target_fault;
  else if (!source_fault.empty())
    answer_.reason = "source: " + source_fault;
  else
    answer_ = GlobalLocalization(map, params_, sensorNoise()).localize(scene, prior);

  converged_ = !answer_.hypotheses.empty();
  nr_iterations_ = converged_ ? 1 : 0;
  const Eigen::Isometry3d T = converged_ ? getFinalPose() : prior.T;
  if (converged_) transformation_ = final_transformation_ = T.matrix().template cast<float>();
  if (prior.T.matrix().allFinite())
    for (PointT& p : output) transformPoint(T, p);
}

template <typename PointT>
void RankedRegistration<PointT>::reset(const std::string& reason) {
  converged_ = false;
  final_transformation_ = transformation_ = Matrix4::Identity();
  nr_iterations_ = 0;
  answer_ = {};
  answer_.reason = reason;
}

}  // namespace facetloc
