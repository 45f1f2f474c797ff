// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/candidate_pairs.h>
#include <facetloc/registration/pair_registration.h>

#include <pcl/impl/pcl_base.hpp>
#include <pcl/registration/registration.h>

#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A kd-tree that is built when it is first asked: pcl::Registration sets one up for every target,
 * which costs more than our whole registration, and only getFitnessScore() ever asks it. Points that were not
 * measured have no neighbours. */
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
    if (isSearchable(point) && Base::nearestKSearch(point, k, indices, distances) > 0)
      return static_cast<int>(indices.size());
    indices.clear();
    distances.assign(1, std::numeric_limits<float>::infinity());  // getFitnessScore() looks at the first
    return 0;
  }
  int radiusSearch(const PointT& point, double radius, pcl::Indices& indices, std::vector<float>& distances,
                   unsigned max_nn = 0) const override {
    if (isSearchable(point)) return Base::radiusSearch(point, radius, indices, distances, max_nn);
    indices.clear();
    distances.clear();
    return 0;
  }

private:
  void remember(const PointCloudConstPtr& cloud, const IndicesConstPtr& indices) {
    this->input_ = cloud;  // which searches by index use
    this->indices_ = indices;
    waiting_ = true;
  }
  bool isSearchable(const PointT& point) const {
    if (!this->input_ || this->input_->empty() || !pcl::isXYZFinite(point)) return false;
    if (waiting_) {
      const PointCloudConstPtr cloud = this->input_;
      const IndicesConstPtr indices = this->indices_;
      const_cast<LazyKdTree*>(this)->Base::setInputCloud(cloud, indices);
      waiting_ = false;
    }
    return true;
  }
  mutable bool waiting_ = false;
};

/** \brief The common base of our registrations: pcl::Registration outside, a ranked list of hypotheses
 * inside.
 *
 * hasConverged() means that the answer is sure: the first pose has the probability setMinProbability(), also
 * against that the two clouds have nothing in common. A doubtful answer also has a final transformation, that
 * of its first pose; it is a guess, and a warning says so. Without an answer, PCL's console shows the
 * reason.
 *
 * PCL's setters have these effects: setMaxCorrespondenceDistance() drops pairs whose source segment, moved by
 * the guess, has its middle farther from the plane of the target [m]; setCorrespondenceEstimation() and
 * addCorrespondenceRejector() choose pairs of segment frames (EkfRegistration), and clouds of points are not
 * aligned with them; numbers of iterations, epsilons and estimators of transformations have nothing to act
 * on, and a warning says so, once per object. The target is read once, by the first align() after it was set,
 * for any number of sources.
 *
 * Without a guess and a covariance of one, a source that is turned about its optical axis by quarters is
 * found as well, at odds of one to ten.
 *
 * The answer of align() stays until another cloud is set. Unlike PCL's base, a missing, empty or unusable
 * cloud, or indices beyond it, never leave the answer of the call before: hasConverged() is then false, the
 * final transformation the identity, the output the source as it is, and getReason() says why. */
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
  /** \name The points of the source that count, as in PCL; which ones are wrong shows when it is aligned. */
  /// @{
  void setIndices(const pcl::IndicesPtr& chosen) override { Base::setIndices(chosen), rememberIndices(); }
  void setIndices(const pcl::IndicesConstPtr& chosen) override {
    Base::setIndices(chosen), rememberIndices();
  }
  void setIndices(const pcl::PointIndicesConstPtr& chosen) override {
    Base::setIndices(chosen), rememberIndices();
  }
  void setIndices(std::size_t row, std::size_t column, std::size_t rows, std::size_t columns) override {
    Base::setIndices(row, column, rows, columns), rememberIndices();
  }
  /// @}

  /** \brief Throws std::invalid_argument for a parameter out of its range. */
  void setRegistrationParams(const RegistrationParams& params) { params_ = checked(params), forgetTarget(); }
  const RegistrationParams& getRegistrationParams() const { return params_; }
  /** \brief Covariance of the guess given to align(), order (phi, t); the parameters' prior unless
   * set. */
  void setPriorCovariance(const Matrix6d& P) { prior_covariance_ = P; }
  Matrix6d getPriorCovariance() const {
    return prior_covariance_ ? *prior_covariance_ : posePrior({}, params_.prior);
  }

  /** \brief Least probability of the first pose with which the registration has converged; 0.9 unless set.
   * Throws std::invalid_argument outside of (0, 1]. */
  void setMinProbability(double p) {
    if (!(p > 0 && p <= 1))
      throw std::invalid_argument("the least probability must be above 0 and at most 1");
    min_probability_ = p;
  }
  double getMinProbability() const { return min_probability_; }

  /** \brief All poses of the source in the target, best first; may be empty. */
  const std::vector<Hypothesis>& getHypotheses() const { return answer_.hypotheses; }
  /** \brief T_target_source of the best hypothesis in double precision; identity without a hypothesis. */
  Eigen::Isometry3d getFinalPose() const;
  /** \brief Its covariance, order (phi, t), left and decoupled; zero without a hypothesis. */
  Matrix6d getFinalCovariance() const;
  /** \brief Its probability; 0 without a hypothesis, or if scores are overlaps, which have no probabilities.
   */
  double getProbability() const;
  /** \brief Sure, doubtful or unknown. */
  AnswerState getState() const { return answer_.stateAt(min_probability_); }
  /** \brief As PCL's, the mean squared distance of the aligned source from its nearest points of the target
   * [m^2], over an even sample of the source: in tens of milliseconds. Through a pointer to PCL's class, all
   * points are asked. */
  double getFitnessScore(double max_range = std::numeric_limits<double>::max());
  using Base::getFitnessScore;
  /** \brief Why there is no sure answer; empty if there is one. */
  const std::string& getReason() const { return status_; }

protected:
  /** \brief The view of the chosen points of a cloud, or without segments and why there are none. */
  virtual View makeView(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices,
                        std::string& why_empty) = 0;
  /** \brief A finer view of the same points, by which they are registered if the usual one leaves no sure
   * answer; empty if not available. */
  virtual std::optional<View> makeFinerView(const pcl::PointCloud<PointT>& cloud,
                                            const pcl::Indices* indices) {
    static_cast<void>(cloud), static_cast<void>(indices);
    return std::nullopt;
  }
  /** \brief Moves one point and turns its normal; points with more than these override it. */
  virtual void transformPoint(const Eigen::Isometry3d& T, PointT& p) const {
    p.getVector3fMap() = (T * p.getVector3fMap().template cast<double>()).template cast<float>();
    if constexpr (pcl::traits::has_normal<PointT>::value) {
      const Eigen::Vector3d normal(p.normal_x, p.normal_y, p.normal_z), turned = T.linear() * normal;
      p.normal_x = static_cast<float>(turned.x());
      p.normal_y = static_cast<float>(turned.y());
      p.normal_z = static_cast<float>(turned.z());
    }
  }
  /** \brief The pairs of source and target that may correspond, by their places in both views; none if the
   * search chooses them itself. */
  virtual std::optional<std::vector<SegmentPair>> choosePairs(const PoseWithCovariance& guess) {
    static_cast<void>(guess);
    return std::nullopt;
  }
  /** \brief True if PCL's estimations and rejectors of correspondences choose these pairs. */
  virtual bool takesCorrespondences() const { return false; }
  /** \brief To be called when the view of the target would come out another. */
  void forgetTarget() { in_target_.reset(), in_finer_target_.reset(); }
  void computeTransformation(PointCloudSource& output, const Matrix4& guess) override;

  using Base::converged_;
  using Base::corr_dist_threshold_;
  using Base::correspondence_estimation_;
  using Base::correspondence_rejectors_;
  using Base::fake_indices_;
  using Base::final_transformation_;
  using Base::indices_;
  using Base::input_;
  using Base::nr_iterations_;
  using Base::reg_name_;
  using Base::target_;
  using Base::target_cloud_updated_;
  using Base::transformation_;
  using Base::use_indices_;

private:
  void reset(const std::string& reason);
  void rememberIndices();
  void applyIndices();
  void readTarget();
  Localization alignFiner(const PoseWithCovariance& prior);
  Localization registered(const View& scene, const PoseWithCovariance& prior);
  std::optional<std::vector<SegmentPair>> nearPairs(const View& scene, const View& target,
                                                    const PoseWithCovariance& guess,
                                                    std::optional<std::vector<SegmentPair>> pairs) const;
  void warnOfSetters();

  pcl::IndicesPtr chosen_;  // the points of the source that count; null = all
  bool indices_fit_ = true;
  RegistrationParams params_;
  std::optional<Matrix6d> prior_covariance_;
  double min_probability_ = kMinProbability;
  std::shared_ptr<const PairRegistration> in_target_;        // null until the target was read
  std::shared_ptr<const PairRegistration> in_finer_target_;  // null until it is needed
  std::string target_fault_;
  int unset_iterations_ = this->max_iterations_;
  bool has_warned_ = false;
  Localization answer_;
  std::string status_;
};

}  // namespace facetloc

#include <facetloc/registration/impl/ranked_registration.hpp>
