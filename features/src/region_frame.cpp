// SPDX-License-Identifier: BSD-3-Clause
#include "base/plane_region.h"
#include "base/polygon.h"

#include <facetloc/features/region_frame.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace facetloc {

using namespace internal;
namespace {

using Points = std::vector<Eigen::Vector3d>;

// The camera that support and uncertainty are expressed for: a Kinect at 320x240.
const Intrinsics kReference{320, 240, 292.35, 292.35, 159.5, 119.5};
constexpr double kLeastDistance = 1e-3;  // nearer points have no direction [m]
constexpr double kLeastCosine = 1e-3;    // between ray and normal: the plane runs along rays below it

// A plane m . p = 1 about the viewpoint, with axes in it.
struct Plane {
  explicit Plane(const Eigen::Vector3d& the_m) : m(the_m) {
    const Eigen::Vector3d n = m.normalized();
    const Eigen::Vector3d x = n.unitOrthogonal();
    axes << x, n.cross(x), n;
    origin = n / m.norm();
  }
  // Where the ray to a point meets the plane; false if it never does.
  bool meet(const Eigen::Vector3d& p, Eigen::Vector2d& at) const {
    const double cosine = axes.col(2).dot(p.normalized());
    if (!(cosine > kLeastCosine)) return false;
    at = (axes.transpose() * (p / m.dot(p) - origin)).head<2>();
    return true;
  }
  Eigen::Vector3d inSpace(const Eigen::Vector2d& at) const { return origin + axes.leftCols<2>() * at; }

  Eigen::Vector3d m, origin;
  Eigen::Matrix3d axes;  // columns: two in the plane, its normal
};

// Outline of the part of the plane that the points show.
Polygon outlineOf(const Points& points, const Plane& plane) {
  Polygon in_plane, hull;
  in_plane.reserve(points.size());
  Eigen::Vector2d at;
  for (const Eigen::Vector3d& p : points)
    if (plane.meet(p, at)) in_plane.push_back(at);
  std::sort(in_plane.begin(), in_plane.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  convexHull(in_plane, hull);
  simplify(hull, ConvexHull::kMaxVertices);
  return hull;
}

// Moments of weighted points.
struct Moments {
  double weight = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Matrix3d pp = Eigen::Matrix3d::Zero(), rays = Eigen::Matrix3d::Zero();

  void add(const Eigen::Vector3d& point, double w) {
    const Eigen::Vector3d ray = point.normalized();
    weight += w;
    p += w * point;
    pp += w * point * point.transpose();
    rays += w * ray * ray.transpose();
  }
};

// Moments of a convex polygon as a camera sees it: each piece counts by the solid angle that it takes.
Moments seenOf(const Polygon& outline, const Plane& plane) {
  constexpr int kPieces = 12;  // along an edge of each triangle of the fan
  Moments seen;
  for (std::size_t i = 2; i < outline.size(); ++i) {
    const Eigen::Vector2d &o = outline[0], a = (outline[i - 1] - o) / kPieces, b = (outline[i] - o) / kPieces;
    const double area = std::abs(a.x() * b.y() - a.y() * b.x()) / 2;
    const auto addPiece = [&](double along_a, double along_b) {
      const Eigen::Vector3d p = plane.inSpace(o + along_a * a + along_b * b);
      seen.add(p, area * plane.axes.col(2).dot(p) / std::pow(p.norm(), 3));
    };
    for (int k = 0; k < kPieces; ++k)
      for (int l = 0; k + l < kPieces; ++l) {
        addPiece(k + 1. / 3, l + 1. / 3);
        if (k + l + 1 < kPieces) addPiece(k + 2. / 3, l + 2. / 3);
      }
  }
  return seen;
}

// The segment of a region with this outline on the plane, everything about the viewpoint.
std::optional<Segment> segmentOf(const Plane& plane, const Polygon& outline, const Moments& moments,
                                 double solid_angle, const SensorNoise& noise,
                                 const SegmentEstimationParams& params) {
  if (outline.size() < 3 || !(moments.weight > 0)) return std::nullopt;
  const Eigen::Vector3d mean = moments.p / moments.weight;
  // As a camera sees it that looks at its middle.
  const Eigen::Matrix3d R = rotationBetween(mean, Eigen::Vector3d::UnitZ());
  PlaneRegion region;
  region.support = solid_angle * kReference.fx * kReference.fy;
  region.m = R * plane.m;
  region.mean = R * mean;
  region.covariance = R * (moments.pp / moments.weight - mean * mean.transpose()) * R.transpose();
  region.rays = R * (region.support / moments.weight * moments.rays) * R.transpose();
  Segment s;
  const char* why_not = "";
  if (!(region.support >= 1) || !describe(region, kReference, noise, params, s, why_not)) return std::nullopt;
  s = transformed(s, Eigen::Isometry3d(Eigen::Quaterniond(R.transpose())));
  for (const Eigen::Vector2d& at : outline) {
    const Eigen::Vector2f vertex = (s.R.transpose() * (plane.inSpace(at) - s.t)).head<2>().cast<float>();
    if (vertex.cwiseAbs().maxCoeff() < ConvexHull::kLargest) s.hull.vertex[s.hull.size++] = vertex;
  }
  if (s.hull.size < 3 || !(s.hull.area() > 0)) return std::nullopt;
  return s;
}

Points about(const Eigen::Vector3d& viewpoint, const Points& points) {
  Points relative;
  relative.reserve(points.size());
  for (const Eigen::Vector3d& p : points)
    if (p.allFinite() && (p - viewpoint).norm() > kLeastDistance) relative.push_back(p - viewpoint);
  return relative;
}

std::optional<Segment> placedAt(const Eigen::Vector3d& viewpoint, std::optional<Segment> segment) {
  if (segment) segment->t += viewpoint;
  return segment;
}

}  // namespace

std::optional<Segment> regionSegment(const Points& points, const Eigen::Vector3d& viewpoint,
                                     const SensorNoise& noise, const SegmentEstimationParams& params) {
  if (!viewpoint.allFinite()) return std::nullopt;
  const Points relative = about(viewpoint, points);
  Moments moments;
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : relative) {
    moments.add(p, 1);
    right += p / p.squaredNorm();  // the ray times the inverse distance
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(moments.rays);
  constexpr double kLeastCondition = 1e-12;  // below it, all rays lie in a plane
  if (relative.size() < 3 || !(solver.rcond() > kLeastCondition)) return std::nullopt;
  const Eigen::Vector3d m = solver.solve(right);
  if (!m.allFinite() || m.isZero() || !(m.dot(moments.p) > 0)) return std::nullopt;
  const Plane plane(m);
  const Polygon outline = outlineOf(relative, plane);
  return placedAt(viewpoint,
                  segmentOf(plane, outline, moments, seenOf(outline, plane).weight, noise, params));
}

std::optional<Segment> regionSegment(const Eigen::Vector4d& coefficients, const Points& outline_points,
                                     const Eigen::Vector3d& viewpoint, const SensorNoise& noise,
                                     const SegmentEstimationParams& params) {
  const double offset = -coefficients[3] - coefficients.head<3>().dot(viewpoint);
  const Eigen::Vector3d m = coefficients.head<3>() / offset;
  if (!m.allFinite() || m.isZero()) return std::nullopt;  // seen edge-on, or no plane
  const Plane plane(m);
  const Polygon outline = outlineOf(about(viewpoint, outline_points), plane);
  const Moments seen = seenOf(outline, plane);
  return placedAt(viewpoint, segmentOf(plane, outline, seen, seen.weight, noise, params));
}

}  // namespace facetloc
