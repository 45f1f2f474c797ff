// SPDX-License-Identifier: BSD-3-Clause
#include "base/inverse_depth.h"
#include "base/lanes.h"
#include "base/plane_region.h"
#include "base/polygon.h"
#include "base/room.h"

#include <facetloc/features/plane_fit.h>
#include <facetloc/features/segment_estimation.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace facetloc {

using namespace internal;
namespace {

constexpr double kTrim = 3.0;  // residual beyond which a pixel leaves the fit [noise std]

// Sums over the points z b of a region, from which centroid and covariance follow.
struct PointMoments {
  double n = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Matrix3d pp = Eigen::Matrix3d::Zero();
};

// Sums over pixels (u, v) of inverse depth d, lane by lane; they are added up once for a region, not once for
// each of its many short runs.
struct PlaneSums {
  LaneSums n, u, v, d, uu, uv, vv, ud, vd, dd;

  PlaneMoments moments() const {
    PlaneMoments m;
    m.n = total(n), m.u = total(u), m.v = total(v), m.d = total(d);
    m.uu = total(uu), m.uv = total(uv), m.vv = total(vv);
    m.ud = total(ud), m.vd = total(vd), m.dd = total(dd);
    return m;
  }
};

// Sums with depth z and its square.
struct DepthSums {
  LaneSums z, zu, zv, zz, zzu, zzv, zzuu, zzuv, zzvv;
};

// First and last column of a region in a row; first > last in a row without it.
struct RowExtreme {
  int first, last;
};

struct Region {
  PlaneSums sums;
  DepthSums depths;
  PlaneMoments plane;
  PointMoments points;
  PixelPlane fitted;
  double tolerance = 0;                // residual beyond which a pixel does not count
  RowExtreme* row_extremes = nullptr;  // one per row; none if the region is too small from the start
};

// Pixels [begin, end) of row v that have the same label, which is not 0.
struct Run {
  std::int32_t label, v, begin, end;
};

// The first column from u on that has another label than column u.
int endOfRun(const std::uint16_t* row, int u, int width) {
  constexpr int kTogether = 4;
  const std::uint16_t label = row[u++];
  const std::uint64_t same = label * 0x0001000100010001u;
  for (std::uint64_t four; u + kTogether <= width; u += kTogether) {
    std::memcpy(&four, row + u, sizeof four);
    if (four != same) break;
  }
  while (u < width && row[u] == label) ++u;
  return u;
}

void findRuns(const LabelImage& labels, std::vector<Run>& runs) {
  constexpr int kShortOnAverage = 8;  // [px]; those of rooms are longer
  runs.clear();
  runs.reserve(labels.label.size() / kShortOnAverage);
  for (int v = 0; v < labels.height; ++v) {
    const std::uint16_t* row = labels.label.data() + static_cast<std::size_t>(v) * labels.width;
    for (int begin = 0, end; begin < labels.width; begin = end) {
      end = endOfRun(row, begin, labels.width);
      if (row[begin]) runs.push_back({row[begin], v, begin, end});
    }
  }
}

// Adds all measured pixels of a run that begins at (u, v); the image ends at end.
FACETLOC_MULTIVERSION void sumMeasured(const float* d, const float* end, int length, int u, int v,
                                       PlaneSums& sums) {
  Doubles n{}, u1{}, u2{}, d1{}, ud{}, dd{}, column = kDoubleOffset + static_cast<double>(u);
  for (int i = 0; i < length; i += kDoubleLanes) {
    FloatQuad pixel;
    load(d + i, end, pixel);
    const IntQuad counts = (pixel > 0) & (kQuadLane < length - i);
    const Doubles one = __builtin_convertvector(counts & 1, Doubles);
    const Doubles value = __builtin_convertvector((FloatQuad)((IntQuad)pixel & counts), Doubles);
    const Doubles one_u = one * column;
    n += one, u1 += one_u, u2 += one_u * column;
    d1 += value, ud += value * column, dd += value * value;
    column += static_cast<double>(kDoubleLanes);
  }
  const double row = v;
  sums.n += n, sums.u += u1, sums.v += row * n, sums.d += d1;
  sums.uu += u2, sums.uv += row * u1, sums.vv += row * row * n;
  sums.ud += ud, sums.vd += row * d1, sums.dd += dd;
}

// Adds the measured pixels whose inverse depth is near start + k slope for the k-th of the run.
FACETLOC_MULTIVERSION void sumSupport(const float* d, const float* end, const float* z, int length,
                                      float start, float slope, float tolerance, int u, int v,
                                      PlaneSums& sums, DepthSums& depths) {
  Doubles n{}, u1{}, u2{}, d1{}, ud{}, dd{}, z1{}, zu{}, zz{}, zzu{}, zzuu{};
  Doubles column = kDoubleOffset + static_cast<double>(u);
  FloatQuad offset = kQuadOffset;
  for (int i = 0; i < length; i += kDoubleLanes) {
    FloatQuad inverse, depth;
    load(d + i, end, inverse);
    load(z + i, z + (end - d), depth);
    const FloatQuad e = inverse - (start + slope * offset);
    const IntQuad counts = (inverse > 0) & (e <= tolerance) & (e >= -tolerance) & (kQuadLane < length - i);
    const Doubles one = __builtin_convertvector(counts & 1, Doubles);
    const Doubles value = __builtin_convertvector((FloatQuad)((IntQuad)inverse & counts), Doubles);
    const Doubles range = __builtin_convertvector((FloatQuad)((IntQuad)depth & counts), Doubles);
    const Doubles one_u = one * column, squared = range * range, squared_u = squared * column;
    n += one, u1 += one_u, u2 += one_u * column;
    d1 += value, ud += value * column, dd += value * value;
    z1 += range, zu += range * column, zz += squared, zzu += squared_u, zzuu += squared_u * column;
    column += static_cast<double>(kDoubleLanes), offset += static_cast<float>(kDoubleLanes);
  }
  const double row = v;
  sums.n += n, sums.u += u1, sums.v += row * n, sums.d += d1;
  sums.uu += u2, sums.uv += row * u1, sums.vv += row * row * n;
  sums.ud += ud, sums.vd += row * d1, sums.dd += dd;
  depths.z += z1, depths.zu += zu, depths.zv += row * z1;
  depths.zz += zz, depths.zzu += zzu, depths.zzv += row * zz;
  depths.zzuu += zzuu, depths.zzuv += row * zzu, depths.zzvv += row * row * zz;
}

// Moments of n points z b, where b = ((u - c_x) / f_x, (v - c_y) / f_y, 1).
PointMoments pointMoments(double n, const DepthSums& sums, const Intrinsics& c) {
  const double z = total(sums.z), zu = total(sums.zu), zv = total(sums.zv);
  const double zz = total(sums.zz), zzu = total(sums.zzu), zzv = total(sums.zzv);
  const double xx = (total(sums.zzuu) - 2 * c.cx * zzu + c.cx * c.cx * zz) / (c.fx * c.fx);
  const double yy = (total(sums.zzvv) - 2 * c.cy * zzv + c.cy * c.cy * zz) / (c.fy * c.fy);
  const double xy = (total(sums.zzuv) - c.cy * zzu - c.cx * zzv + c.cx * c.cy * zz) / (c.fx * c.fy);
  const double x = (zzu - c.cx * zz) / c.fx, y = (zzv - c.cy * zz) / c.fy;
  PointMoments m;
  m.n = n;
  m.p << (zu - c.cx * z) / c.fx, (zv - c.cy * z) / c.fy, z;
  m.pp << xx, xy, x, xy, yy, y, x, y, zz;
  return m;
}

// First pass: the plane of each region from all of its pixels, and how far they scatter.
void fitRegions(const Intrinsics& camera, const std::vector<float>& inverse, const std::vector<Run>& runs,
                const DepthNoise& noise, std::vector<Region>& regions) {
  for (const auto& [label, v, begin, end] : runs)
    sumMeasured(inverse.data() + static_cast<std::size_t>(v) * camera.width + begin,
                inverse.data() + inverse.size(), end - begin, begin, v, regions[label].sums);
  for (Region& r : regions) {
    r.plane = r.sums.moments();
    const PlaneMoments::Fit fit = r.plane.fit();
    r.fitted = fit.plane;
    if (!(r.plane.n > 0 && r.plane.d > 0)) continue;  // nothing of it is measured
    const double rms = std::sqrt(fit.sse / r.plane.n), depth = r.plane.n / r.plane.d;
    r.tolerance = kTrim * std::max(noise.ofInverseDepth(depth), rms);
  }
}

// Second pass: plane and points of the pixels that belong, row by row.
void gatherSupport(const DepthImage& image, const std::vector<float>& inverse, const std::vector<Run>& runs,
                   double min_support, std::vector<Region>& regions, std::vector<RowExtreme>& row_extremes) {
  const Intrinsics& c = image.camera;
  const auto is_large = [&](const Region& r) { return r.plane.n >= min_support; };
  const std::size_t rows = std::count_if(regions.begin(), regions.end(), is_large) * c.height;
  makeRoom(row_extremes, rows);
  row_extremes.assign(rows, {c.width, -1});
  RowExtreme* next = row_extremes.data();
  for (Region& r : regions) {
    if (is_large(r)) r.row_extremes = next, next += c.height;
    r.sums = {};
  }
  for (const auto& [label, v, begin, end] : runs) {
    Region& r = regions[label];
    if (!r.row_extremes) continue;
    const std::size_t pixel = static_cast<std::size_t>(v) * c.width + begin;
    const float* d = inverse.data() + pixel;
    const float start = static_cast<float>(r.fitted.at(begin, v)), slope = static_cast<float>(r.fitted.a);
    const float tolerance = static_cast<float>(r.tolerance);
    const auto belongs = [&](int k) {
      return d[k] > 0 && std::fabs(d[k] - (start + slope * static_cast<float>(k))) <= tolerance;
    };
    int first = 0, last = end - begin - 1;
    while (first <= last && !belongs(first)) ++first;
    if (first > last) continue;
    while (!belongs(last)) --last;
    RowExtreme& row = r.row_extremes[v];
    row.first = std::min(row.first, begin + first), row.last = std::max(row.last, begin + last);
    sumSupport(d, inverse.data() + inverse.size(), image.depth.data() + pixel, end - begin, start, slope,
               tolerance, begin, v, r.sums, r.depths);
  }
  for (Region& r : regions) {
    r.plane = r.sums.moments();
    r.points = pointMoments(r.plane.n, r.depths, c);
  }
}

// Sum of b b^T over the pixels of the moments.
Eigen::Matrix3d rayMoments(const PlaneMoments& m, const Intrinsics& c) {
  const double x = (m.u - c.cx * m.n) / c.fx, y = (m.v - c.cy * m.n) / c.fy;
  const double xx = (m.uu - 2 * c.cx * m.u + c.cx * c.cx * m.n) / (c.fx * c.fx);
  const double yy = (m.vv - 2 * c.cy * m.v + c.cy * c.cy * m.n) / (c.fy * c.fy);
  const double xy = (m.uv - c.cy * m.u - c.cx * m.v + c.cx * c.cy * m.n) / (c.fx * c.fy);
  Eigen::Matrix3d bb;
  bb << xx, xy, x, xy, yy, y, x, y, m.n;
  return bb;
}

// The row extremes come sorted by v, then u. Exact: the coordinates are integers.
void pixelHull(const RowExtreme* row_extremes, int height, Polygon& points, Polygon& hull) {
  points.clear();
  for (int v = 0; v < height; ++v) {
    const auto [first, last] = row_extremes[v];
    if (first > last) continue;
    points.emplace_back(first, v);
    if (last > first) points.emplace_back(last, v);
  }
  convexHull(points, hull);
}

// Perspective keeps convexity, so the hull of the pixels is the hull of the points on the plane.
ConvexHull hullInPlane(const Polygon& pixels, const Intrinsics& camera, const Segment& s, double rho) {
  ConvexHull hull;
  for (const Eigen::Vector2d& pixel : pixels) {
    const Eigen::Vector3d b = camera.ray(pixel.x(), pixel.y());
    const double along = s.normal().dot(b);
    if (along < 1e-3) continue;  // the fitted plane runs along this ray: no point to speak of
    const Eigen::Vector3d p = s.R.transpose() * (b * (rho / along) - s.t);
    const Eigen::Vector2f vertex = p.head<2>().cast<float>();
    if (vertex.cwiseAbs().maxCoeff() < ConvexHull::kLargest) hull.vertex[hull.size++] = vertex;
  }
  if (hull.area() < 0) std::reverse(hull.vertex.begin(), hull.vertex.begin() + hull.size);
  return hull;
}

void rankByInformation(const std::vector<Segment>& segments, std::vector<double>& share,
                       std::vector<int>& order) {
  Eigen::Matrix3d Y = Eigen::Matrix3d::Zero();
  for (const Segment& s : segments) Y += s.num_points * s.normal() * s.normal().transpose();
  share.resize(segments.size());  // METHOD 9
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const double all = segments[i].normal().dot(Y * segments[i].normal());
    share[i] = all > 0 ? segments[i].num_points / all : 0;
  }
  order.resize(segments.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return share[a] > share[b] || (share[a] == share[b] && a < b); });
}

}  // namespace

struct SegmentEstimation::Buffers {
  std::vector<float> inverse;  // depth
  std::vector<Run> runs;
  std::vector<Region> regions;  // indexed by label
  std::vector<RowExtreme> row_extremes;
  Polygon points, hull;
  std::vector<Segment> found;
  std::vector<int> label_of, order;
  std::vector<double> share;

  bool makeSegment(Region& r, const Intrinsics& camera, const SensorNoise& noise,
                   const SegmentEstimationParams& params, double min_support, Segment& s,
                   const char*& why_not) {
    why_not = "has too few measured pixels on its plane";
    if (r.plane.n < min_support) return false;
    const Eigen::Vector3d mean = r.points.p / r.points.n;
    const PlaneRegion region{r.plane.n, r.plane.fit().plane.toSpace(camera),  // METHOD 5.1
                             mean, r.points.pp / r.points.n - mean * mean.transpose(),
                             rayMoments(r.plane, camera)};
    if (!describe(region, camera, noise, params, s, why_not)) return false;
    why_not = "has no outline";
    pixelHull(r.row_extremes, camera.height, points, hull);
    simplify(hull, ConvexHull::kMaxVertices);
    s.hull = hullInPlane(hull, camera, s, 1 / region.m.norm());
    return s.hull.size >= 3 && s.hull.area() > 0;
  }
};

SegmentEstimation::SegmentEstimation(const SegmentEstimationParams& params)
    : params_(params), buffers_(std::make_unique<Buffers>()) {}
SegmentEstimation::~SegmentEstimation() = default;
SegmentEstimation::SegmentEstimation(const SegmentEstimation& other) : SegmentEstimation(other.params_) {}
SegmentEstimation& SegmentEstimation::operator=(const SegmentEstimation& other) {
  params_ = other.params_;
  buffers_ = std::make_unique<Buffers>();
  return *this;
}

void SegmentEstimation::estimate(const DepthImage& image, const LabelImage& labels, const SensorNoise& noise,
                                 std::vector<Segment>& segments, std::vector<int>& kept,
                                 std::vector<LeftOutRegion>* left_out) {
  segments.clear();
  kept.clear();
  if (left_out) left_out->clear();
  if (labels.label.size() != image.depth.size() || labels.width != image.camera.width ||
      labels.height != image.camera.height)
    throw std::invalid_argument("labels and depth image differ in size");
  if (!image.valid()) return;
  Buffers& b = *buffers_;
  b.inverse.resize(image.depth.size());
  invertDepth(image.depth.data(), image.depth.size(), 1.f, b.inverse.data());
  findRuns(labels, b.runs);
  std::int32_t max_label = 0;
  for (const Run& run : b.runs) max_label = std::max(max_label, run.label);
  makeRoom(b.regions, max_label + 1);
  b.regions.assign(max_label + 1, {});
  fitRegions(image.camera, b.inverse, b.runs, noise, b.regions);
  const double min_support = std::max(3.0, scaledPixels(params_.min_support, image.camera));
  gatherSupport(image, b.inverse, b.runs, min_support, b.regions, b.row_extremes);

  b.found.clear();
  b.label_of.clear();
  for (int label = 1; label <= max_label; ++label) {
    Segment s;
    const char* why_not = "";
    if (!b.makeSegment(b.regions[label], image.camera, noise, params_, min_support, s, why_not)) {
      if (left_out) left_out->push_back({label, why_not});
      continue;
    }
    b.found.push_back(s);
    b.label_of.push_back(label);
  }
  rankByInformation(b.found, b.share, b.order);
  for (const int i : b.order) {
    segments.push_back(b.found[i]);
    kept.push_back(b.label_of[i]);
  }
}

std::vector<Segment> estimateSegments(const DepthImage& image, const LabelImage& labels,
                                      const SensorNoise& noise, const SegmentEstimationParams& params,
                                      std::vector<int>* kept, std::vector<LeftOutRegion>* left_out) {
  std::vector<Segment> segments;
  std::vector<int> of_segments;
  SegmentEstimation(params).estimate(image, labels, noise, segments, of_segments, left_out);
  if (kept) kept->swap(of_segments);
  return segments;
}

std::vector<int> rankByInformation(const std::vector<Segment>& segments) {
  std::vector<double> share;
  std::vector<int> order;
  rankByInformation(segments, share, order);
  return order;
}

}  // namespace facetloc
