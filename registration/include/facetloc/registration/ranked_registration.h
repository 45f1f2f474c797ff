// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/global_localization.h>

#include <pcl/impl/pcl_base.hpp>
#include <pcl/registration/registration.h>

#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A kd-tree that is built when it is first asked: pcl::Registration sets one up for every target,
 * which costs more than our whole registration, and only getFitnessScore() ever asks it. */
template <typename PointT>
class LazyKdTree : public pcl::search::KdTree<PointT> {
public:
  using Base = pcl::search::KdTree<PointT>;
  using PointCloudConstPtr = typename Base::PointCloudConstPtr;
  using IndicesConstPtr = typename Base::IndicesConstPtr;

#if PCL_VERSION_COMPARE(>=, 1, 14, 0)
  bool setInputCloud(const PointCloudConstPtr& cloud,
                     const IndicesConstPtr& indices = IndicesConstPtr()) override {
    remember(cloud, indices);
    return true;
  }
#else
  void setInputCloud(const PointCloudConstPtr& cloud,
                     const IndicesConstPtr& indices = IndicesConstPtr()) override {
    remember(cloud, indices);
  }
#endif
  using Base::nearestKSearch;
  using Base::radiusSearch;
  int nearestKSearch(const PointT& point, int k, pcl::Indices& indices,
                     std::vector<float>& distances) const override {
    build();
    return Base::nearestKSearch(point, k, indices, distances);
  }
  int radiusSearch(const PointT& point, double radius, pcl::Indices& indices, std::vector<float>& distances,
                   unsigned max_nn = 0) const override {
    build();
    return Base::radiusSearch(point, radius, indices, distances, max_nn);
  }

private:
  void remember(const PointCloudConstPtr& cloud, const IndicesConstPtr& indices) {
    cloud_ = cloud;
    cloud_indices_ = indices;
    waiting_ = true;
  }
  void build() const {
    if (!waiting_) return;
    const_cast<LazyKdTree*>(this)->Base::setInputCloud(cloud_, cloud_indices_);
    waiting_ = false;
  }
  PointCloudConstPtr cloud_;
  IndicesConstPtr cloud_indices_;
  mutable bool waiting_ = false;
};

/** \brief What our registrations share: pcl::Registration outside, a ranked list of hypotheses inside.
 *
 * Unlike PCL's base, a missing, empty or unusable cloud never leaves the answer of the call before:
 * hasConverged() is then false, the final transformation the identity, and getStatus() says why. */
template <typename PointT>
class RankedRegistration : public pcl::Registration<PointT, PointT> {
public:
  using Base = pcl::Registration<PointT, PointT>;
  using typename Base::Matrix4;
  using typename Base::PointCloudSource;
  using typename Base::PointCloudSourceConstPtr;
  using typename Base::PointCloudTargetConstPtr;

  RankedRegistration();

  void setInputSource(const PointCloudSourceConstPtr& cloud) override;
  void setInputTarget(const PointCloudTargetConstPtr& cloud) override;

  void setRegistrationParams(const GlobalLocalizationParams& params) { params_ = params; }
  const GlobalLocalizationParams& getRegistrationParams() const { return params_; }
  /** \brief Covariance of the guess given to align(), order (phi, t); that of the parameters' prior unless
   * set. */
  void setPriorCovariance(const Matrix6d& P) { prior_covariance_ = P; }
  Matrix6d getPriorCovariance() const {
    return prior_covariance_ ? *prior_covariance_ : posePrior({}, params_.prior);
  }

  /** \brief All poses of the source in the target, best first; empty if there is none. */
  const std::vector<Hypothesis>& getHypotheses() const { return answer_.hypotheses; }
  /** \brief T_target_source of the best hypothesis in double precision; identity if there is none. */
  Eigen::Isometry3d getFinalPose() const;
  /** \brief Its covariance, order (phi, t), left and decoupled; zero if there is none. */
  Matrix6d getFinalCovariance() const;
  /** \brief Why there is no answer; empty if there is one. */
  const std::string& getStatus() const { return answer_.reason; }

protected:
  /** \brief The view of the chosen points of a cloud, or without segments and why there are none. */
  virtual View makeView(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices,
                        std::string& why_empty) = 0;
  virtual SensorNoise sensorNoise() const { return {}; }
  /** \brief Moves one point; points with more than a position override it. */
  virtual void transformPoint(const Eigen::Isometry3d& T, PointT& p) const {
    p.getVector3fMap() = (T * p.getVector3fMap().template cast<double>()).template cast<float>();
  }
  void computeTransformation(PointCloudSource& output, const Matrix4& guess) override;

  using Base::converged_;
  using Base::final_transformation_;
  using Base::indices_;
  using Base::input_;
  using Base::nr_iterations_;
  using Base::reg_name_;
  using Base::target_;
  using Base::transformation_;
  using Base::use_indices_;

private:
  void reset(const std::string& reason);

  GlobalLocalizationParams params_;
  std::optional<Matrix6d> prior_covariance_;
  Localization answer_;
};

}  // namespace facetloc

#include <facetloc/registration/impl/ranked_registration.hpp>
