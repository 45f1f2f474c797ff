// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera_model.h>
#include <facetloc/features/segment_frame.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

void setOrientation(SegmentFrame& frame, const Eigen::Quaterniond& q) {
  const Eigen::Quaternionf f = q.normalized().cast<float>();
  for (int i = 0; i < 4; ++i) frame.orientation[i] = f.coeffs()[i];
  const Eigen::Vector3f n = frame.normal();
  frame.normal_x = n.x(), frame.normal_y = n.y(), frame.normal_z = n.z();
}

// Does the normal fit the orientation?
bool normalFits(const SegmentFrame& frame) {
  constexpr float kTolerance = 1e-2f;
  const Eigen::Vector3f n(frame.normal_x, frame.normal_y, frame.normal_z);
  return (n - frame.normal()).norm() <= kTolerance;  // false for NaN
}

bool finite(const float* values, int n) {
  for (int i = 0; i < n; ++i)
    if (!std::isfinite(values[i])) return false;
  return true;
}

// A contour is empty, or a counter-clockwise polygon of a size that a depth camera can see.
bool wellFormed(const ConvexHull& hull) {
  if (hull.size == 0) return true;
  const bool bounded = std::all_of(hull.begin(), hull.end(), [](const Eigen::Vector2f& v) {
    return v.cwiseAbs().maxCoeff() < ConvexHull::kLargest;
  });
  return hull.size >= 3 && bounded && hull.area() > 0;
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const SegmentFrame& f) {
  const Eigen::Vector3f n = f.normal();
  return out << "(" << f.x << "," << f.y << "," << f.z << " - " << n.x() << "," << n.y() << "," << n.z()
             << " - " << f.num_points << " points)";
}

SegmentFrame toSegmentFrame(const Segment& s) {
  SegmentFrame f;
  f.getVector3fMap() = s.t.cast<float>();
  setOrientation(f, Eigen::Quaterniond(s.R));
  for (int i = 0, k = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) f.sigma_q[k++] = static_cast<float>(s.Sigma_q(i, j));
  f.lambda[0] = static_cast<float>(s.lambda[0]);
  f.lambda[1] = static_cast<float>(s.lambda[1]);
  f.num_points = s.num_points;
  f.noise = static_cast<float>(s.noise);
  f.hull_size = s.hull.size;
  for (int i = 0; i < s.hull.size; ++i) {
    f.hull[2 * i] = s.hull.vertex[i].x();
    f.hull[2 * i + 1] = s.hull.vertex[i].y();
  }
  return f;
}

bool toSegment(const SegmentFrame& f, Segment& out) {
  if (!finite(f.data, 3) || !finite(f.orientation, 4) || !finite(f.sigma_q, 6) || !finite(f.lambda, 2))
    return false;
  if (f.hull_size < 0 || f.hull_size > ConvexHull::kMaxVertices || !finite(f.hull, 2 * f.hull_size))
    return false;
  if (!(f.noise >= 0 && f.noise <= DepthNoise::kLargestInverseDepthStd)) return false;
  if (f.num_points < 0 || f.lambda[0] < 0 || f.lambda[1] < 0) return false;
  const Eigen::Quaterniond q = f.rotation().cast<double>();
  if (std::abs(q.squaredNorm() - 1) > 1e-3 || !normalFits(f)) return false;
  Segment s;
  s.t = f.getVector3fMap().cast<double>();
  s.R = q.normalized().toRotationMatrix();
  for (int i = 0, k = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) s.Sigma_q(i, j) = s.Sigma_q(j, i) = f.sigma_q[k++];
  if (s.Sigma_q.llt().info() != Eigen::Success) return false;
  s.lambda = {f.lambda[0], f.lambda[1]};
  s.num_points = f.num_points;
  s.noise = f.noise;
  s.hull.size = f.hull_size;
  for (int i = 0; i < f.hull_size; ++i) s.hull.vertex[i] = {f.hull[2 * i], f.hull[2 * i + 1]};
  if (!wellFormed(s.hull)) return false;
  out = s;
  return true;
}

pcl::PointCloud<SegmentFrame> toCloud(const std::vector<Segment>& segments) {
  pcl::PointCloud<SegmentFrame> cloud;
  cloud.reserve(segments.size());
  for (const Segment& s : segments) cloud.push_back(toSegmentFrame(s));
  return cloud;
}

SegmentFrame transformed(const SegmentFrame& frame, const Eigen::Isometry3d& T) {
  SegmentFrame out = frame;
  out.getVector3fMap() = (T * frame.getVector3fMap().cast<double>()).cast<float>();
  setOrientation(out, Eigen::Quaterniond(T.linear()) * frame.rotation().cast<double>());
  return out;
}

pcl::PointCloud<SegmentFrame> transformed(const pcl::PointCloud<SegmentFrame>& frames,
                                          const Eigen::Isometry3d& T) {
  pcl::PointCloud<SegmentFrame> out = frames;
  for (SegmentFrame& frame : out) frame = transformed(frame, T);
  return out;
}

}  // namespace facetloc
