// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment_frame.h>
#include <facetloc/registration/candidate_pairs.h>

#include <pcl/registration/correspondence_estimation.h>

namespace facetloc {

/** \brief The initial feature matching of the paper (II.B) as a PCL correspondence estimation.
 *
 * Source frames are those of the scene, target frames those of the local model; the pose and its uncertainty
 * come from setPose(). A correspondence's distance is the squared Mahalanobis distance of the planes, eq.
 * (14). */
class SegmentMatching : public pcl::registration::CorrespondenceEstimationBase<SegmentFrame, SegmentFrame> {
public:
  using Base = pcl::registration::CorrespondenceEstimationBase<SegmentFrame, SegmentFrame>;
  using Ptr = pcl::shared_ptr<SegmentMatching>;
  using ConstPtr = pcl::shared_ptr<const SegmentMatching>;

  SegmentMatching();
  /** \brief T_target_source and its covariance; the wide prior of posePrior() unless set. */
  void setPose(const PoseWithCovariance& T_target_source) { pose_ = T_target_source; }
  void setParams(const MatchingParams& params) { params_ = checked(params); }
  /** \brief As PCL's, which would go on with the old target where the new one is missing or empty. */
  void setInputTarget(const PointCloudTargetConstPtr& cloud) {
    target_.reset();
    if (cloud && !cloud->empty()) Base::setInputTarget(cloud);
  }
  const MatchingParams& getParams() const { return params_; }

  /** \brief All candidate pairs, the most promising first: many per source frame, as the hypothesis tree
   * needs them. max_distance lowers the gate of the parameters. Empty for missing clouds; invalid frames
   * match nothing. */
  void determineCorrespondences(pcl::Correspondences& correspondences,
                                double max_distance = std::numeric_limits<double>::max()) override;
  /** \brief The pairs in which each frame is the best partner of the other. */
  void determineReciprocalCorrespondences(pcl::Correspondences& correspondences,
                                          double max_distance = std::numeric_limits<double>::max()) override;
  Base::Ptr clone() const override { return Base::Ptr(new SegmentMatching(*this)); }

private:
  MatchingParams params_;
  PoseWithCovariance pose_;
};

}  // namespace facetloc
