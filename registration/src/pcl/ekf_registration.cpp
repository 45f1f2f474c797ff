// SPDX-License-Identifier: BSD-3-Clause
#include "pcl/segment_frames.h"

#include <facetloc/registration/ekf_registration.h>

#include <pcl/conversions.h>
#include <pcl/kdtree/impl/kdtree_flann.hpp>
#include <pcl/search/impl/kdtree.hpp>
#include <pcl/search/impl/search.hpp>

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

namespace facetloc {

using namespace internal;

View EkfRegistration::makeView(const pcl::PointCloud<SegmentFrame>& cloud, const pcl::Indices* indices,
                               std::string& why_empty) {
  View view = viewOfSegments(rankedSegments(cloud, indices).segments);
  if (view.segments.empty()) why_empty = "the cloud has no valid segment frame";
  return view;
}

void EkfRegistration::transformPoint(const Eigen::Isometry3d& T, SegmentFrame& frame) const {
  frame = transformed(frame, T);
}

namespace {

using CloudPtr = pcl::PointCloud<SegmentFrame>::ConstPtr;

pcl::PCLPointCloud2::ConstPtr blobOf(const pcl::PointCloud<SegmentFrame>& cloud) {
  auto blob = pcl::make_shared<pcl::PCLPointCloud2>();
  pcl::toPCLPointCloud2(cloud, *blob);
  return blob;
}

// The place of each frame of a cloud in the list of its ranked segments; -1 if it is not there.
std::vector<int> ranks(const pcl::PointCloud<SegmentFrame>& cloud, const pcl::Indices* indices) {
  std::vector<int> rank(cloud.size(), -1);
  const std::vector<int> index = rankedSegments(cloud, indices).index;
  for (std::size_t i = 0; i < index.size(); ++i)
    rank[static_cast<std::size_t>(index[i])] = static_cast<int>(i);
  return rank;
}

int rankOf(int index, const std::vector<int>& rank) {
  return 0 <= index && index < static_cast<int>(rank.size()) ? rank[static_cast<std::size_t>(index)] : -1;
}

}  // namespace

std::optional<std::vector<SegmentPair>> EkfRegistration::choosePairs(const PoseWithCovariance& guess) {
  const pcl::IndicesConstPtr indices = use_indices_ ? indices_ : nullptr;
  const auto moved = pcl::make_shared<pcl::PointCloud<SegmentFrame>>(transformed(*input_, guess.T));
  pcl::Correspondences pairs;
  using Estimation = pcl::registration::CorrespondenceEstimationBase<SegmentFrame, SegmentFrame>;
  const auto find = [&](Estimation& estimation, const CloudPtr& source, double max_distance) {
    estimation.setInputSource(source);
    estimation.setInputTarget(target_);
    if (indices) estimation.setIndicesSource(pcl::make_shared<pcl::Indices>(*indices));
    if (estimation.requiresSourceNormals()) estimation.setSourceNormals(blobOf(*source));
    if (estimation.requiresTargetNormals()) estimation.setTargetNormals(blobOf(*target_));
    estimation.determineCorrespondences(pairs, max_distance);
  };
  constexpr double kAnyDistance = std::numeric_limits<double>::max();  // its own is no length
  if (!correspondence_estimation_) {
    SegmentMatching matching;
    matching.setParams(getRegistrationParams().matching);
    matching.setPose(guess);
    find(matching, input_, kAnyDistance);
  } else if (const auto matching = pcl::dynamic_pointer_cast<SegmentMatching>(correspondence_estimation_)) {
    matching->setPose(guess);
    find(*matching, input_, kAnyDistance);
  } else {
    find(*correspondence_estimation_, moved, corr_dist_threshold_);
  }

  for (const pcl::registration::CorrespondenceRejector::Ptr& rejector : correspondence_rejectors_) {
    if (rejector->requiresSourcePoints()) rejector->setSourcePoints(blobOf(*moved));
    if (rejector->requiresTargetPoints()) rejector->setTargetPoints(blobOf(*target_));
    if (rejector->requiresSourceNormals()) rejector->setSourceNormals(blobOf(*moved));
    if (rejector->requiresTargetNormals()) rejector->setTargetNormals(blobOf(*target_));
    rejector->setInputCorrespondences(pcl::make_shared<pcl::Correspondences>(pairs));
    pcl::Correspondences left;
    rejector->getCorrespondences(left);
    pairs = std::move(left);
  }

  const std::vector<int> source_rank = ranks(*input_, indices.get()), target_rank = ranks(*target_, nullptr);
  const int most = getRegistrationParams().matching.max_segments;
  std::vector<SegmentPair> chosen;
  for (const pcl::Correspondence& c : pairs) {
    const SegmentPair p{rankOf(c.index_query, source_rank), rankOf(c.index_match, target_rank), c.distance};
    if (0 <= p.scene && p.scene < most && 0 <= p.model && p.model < most) chosen.push_back(p);
  }
  const auto inOrder = [](const SegmentPair& a, const SegmentPair& b) {
    return std::tuple(a.scene + a.model, a.scene, a.model) < std::tuple(b.scene + b.model, b.scene, b.model);
  };
  std::sort(chosen.begin(), chosen.end(), inOrder);  // METHOD 4.3
  chosen.erase(std::unique(chosen.begin(), chosen.end(),
                           [](const SegmentPair& a, const SegmentPair& b) {
                             return a.scene == b.scene && a.model == b.model;
                           }),
               chosen.end());
  return chosen;
}

}  // namespace facetloc

template class pcl::PCLBase<facetloc::SegmentFrame>;
template class pcl::KdTreeFLANN<facetloc::SegmentFrame>;
template class pcl::search::KdTree<facetloc::SegmentFrame>;
template class pcl::Registration<facetloc::SegmentFrame, facetloc::SegmentFrame>;
template class facetloc::RankedRegistration<facetloc::SegmentFrame>;
