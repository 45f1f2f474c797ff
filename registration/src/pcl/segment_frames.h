// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment_frame.h>

#include <pcl/types.h>

#include <vector>

namespace facetloc::internal {

/** \brief The valid segments of a cloud in the order that the search needs, and where each came from. */
struct RankedFrames {
  std::vector<Segment> segments;  ///< sorted by information content
  std::vector<int> index;         ///< index of each segment in the cloud
};

/** \brief Reads the frames of a cloud, or of the given indices only; frames with invalid fields are left out.
 */
RankedFrames rankedSegments(const pcl::PointCloud<SegmentFrame>& cloud, const pcl::Indices* indices);

}  // namespace facetloc::internal
