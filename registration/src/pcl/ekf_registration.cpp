// SPDX-License-Identifier: BSD-3-Clause
#include "pcl/segment_frames.h"

#include <facetloc/registration/ekf_registration.h>

#include <pcl/kdtree/impl/kdtree_flann.hpp>
#include <pcl/search/impl/kdtree.hpp>
#include <pcl/search/impl/search.hpp>

namespace facetloc {

using namespace internal;

View EkfRegistration::makeView(const pcl::PointCloud<SegmentFrame>& cloud, const pcl::Indices* indices,
                               std::string& why_empty) {
  View view;
  view.segments = rankedSegments(cloud, indices).segments;
  if (view.segments.empty()) why_empty = "the cloud has no valid segment frame";
  return view;
}

void EkfRegistration::transformPoint(const Eigen::Isometry3d& T, SegmentFrame& frame) const {
  frame = transformed(frame, T);
}

}  // namespace facetloc

template class pcl::PCLBase<facetloc::SegmentFrame>;
template class pcl::KdTreeFLANN<facetloc::SegmentFrame>;
template class pcl::search::KdTree<facetloc::SegmentFrame>;
template class pcl::Registration<facetloc::SegmentFrame, facetloc::SegmentFrame>;
template class facetloc::RankedRegistration<facetloc::SegmentFrame>;
