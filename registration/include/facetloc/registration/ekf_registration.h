// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment_frame.h>
#include <facetloc/registration/ranked_registration.h>
#include <facetloc/registration/segment_matching.h>

namespace facetloc {

/** \brief The registration of the paper (II): aligns two clouds of segment frames by an Extended Kalman
 * Filter over many correspondence hypotheses.
 *
 *     facetloc::EkfRegistration registration;
 *     registration.setInputSource(scene_frames);
 *     registration.setInputTarget(model_frames);
 *     pcl::PointCloud<facetloc::SegmentFrame> aligned;
 *     registration.align(aligned);
 *     if (registration.hasConverged()) use(registration.getFinalPose(), registration.getFinalCovariance());
 *
 * Frames alone carry no depth: the dense steps are skipped. They carry the noise that they were seen with
 * (SegmentFrame::noise), by which poses of a noisier camera may be less certain; 0 counts as a Kinect's.
 * Invalid frames (NaN) are left out.
 *
 * As PCL's base promises, setCorrespondenceEstimation() and addCorrespondenceRejector() choose the pairs that
 * the search may use, in place of SegmentMatching with the parameters of the registration. An estimation of
 * PCL's gets the source moved by the guess, as in pcl::IterativeClosestPoint; a SegmentMatching gets the
 * guess with its covariance as its pose. It should give many pairs per frame: the search finds out which are
 * right. */
class EkfRegistration : public RankedRegistration<SegmentFrame> {
public:
  using Ptr = pcl::shared_ptr<EkfRegistration>;
  using ConstPtr = pcl::shared_ptr<const EkfRegistration>;
  EkfRegistration() { reg_name_ = "EkfRegistration"; }

protected:
  View makeView(const pcl::PointCloud<SegmentFrame>& cloud, const pcl::Indices* indices,
                std::string& why_empty) override;
  void transformPoint(const Eigen::Isometry3d& T, SegmentFrame& frame) const override;
  std::optional<std::vector<SegmentPair>> choosePairs(const PoseWithCovariance& guess) override;
  bool takesCorrespondences() const override { return true; }
};

}  // namespace facetloc

// The PCL base templates for our point type live in libfacetloc_registration: users of the pcl::Registration
// interface need no PCL_NO_PRECOMPILE, no impl/*.hpp and no FLANN or LZ4 on their link line.
extern template class pcl::PCLBase<facetloc::SegmentFrame>;
extern template class pcl::KdTreeFLANN<facetloc::SegmentFrame>;
extern template class pcl::search::KdTree<facetloc::SegmentFrame>;
extern template class pcl::Registration<facetloc::SegmentFrame, facetloc::SegmentFrame>;
extern template class facetloc::RankedRegistration<facetloc::SegmentFrame>;
