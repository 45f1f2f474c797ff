// SPDX-License-Identifier: BSD-3-Clause
#include "pcl/segment_frames.h"

#include <facetloc/features/segment_estimation.h>

#include <numeric>

namespace facetloc::internal {

RankedFrames rankedSegments(const pcl::PointCloud<SegmentFrame>& cloud, const pcl::Indices* indices) {
  pcl::Indices all;
  if (!indices) {
    all.resize(cloud.size());
    std::iota(all.begin(), all.end(), 0);
    indices = &all;
  }
  std::vector<Segment> segments;
  std::vector<int> index;
  for (const int i : *indices) {
    Segment s;
    if (i < 0 || i >= static_cast<int>(cloud.size()) || !toSegment(cloud[i], s)) continue;
    segments.push_back(s);
    index.push_back(i);
  }
  RankedFrames ranked;
  for (const int i : rankByInformation(segments)) {
    ranked.segments.push_back(segments[i]);
    ranked.index.push_back(index[i]);
  }
  return ranked;
}

}  // namespace facetloc::internal
