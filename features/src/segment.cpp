// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/segment.h>

namespace facetloc {

bool ConvexHull::contains(const Eigen::Vector2f& p, float margin) const {
  if (size < 3) return false;
  for (int i = 0, j = size - 1; i < size; j = i++) {
    const Eigen::Vector2f edge = vertex[i] - vertex[j], to_p = p - vertex[j];
    const float cross = edge.x() * to_p.y() - edge.y() * to_p.x();  // = signed distance x edge length
    if (cross < 0 && cross * cross > margin * margin * edge.squaredNorm()) return false;
  }
  return true;
}

float ConvexHull::area() const {
  float twice = 0;
  for (int i = 0, j = size - 1; i < size; j = i++)
    twice += vertex[j].x() * vertex[i].y() - vertex[j].y() * vertex[i].x();
  return 0.5f * twice;
}

Segment transformed(const Segment& segment, const Eigen::Isometry3d& T) {
  Segment out = segment;
  out.R = T.linear() * segment.R;
  out.t = T * segment.t;
  return out;
}

}  // namespace facetloc
