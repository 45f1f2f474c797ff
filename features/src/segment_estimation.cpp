// SPDX-License-Identifier: BSD-3-Clause
#include "shared/inverse_depth.h"
#include "shared/lanes.h"
#include "shared/room.h"

#include <facetloc/features/plane_fit.h>
#include <facetloc/features/segment_estimation.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace facetloc {

using namespace internal;
namespace {

constexpr double kReferenceWidth = 320.0;
constexpr double kMinPlaneDistance =
    0.05;  // planes through the camera centre are seen edge-on [m] (METHOD 8)
// The paper's eq. (4) with its authors' sensor constants: 1 disparity unit, twice the noise, and 1 px at
// 320x240.
constexpr double kPaperDepthFactor = 2.0;
constexpr double kFaithfulPixelStd = 1.0;
constexpr double kCorrelatedPixels =
    100.0;  // pixels at 320x240 that share one independent error, N_eff of METHOD 7.3
constexpr double kMinIndependent = 8.0;
constexpr double kWideInNoise = 5.0;  // a strip this many sigma_r wide has a slope worth measuring

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

// First and last column of a region in a row; first > last where there is none.
struct RowExtreme {
  int first, last;
};

struct Region {
  PlaneSums sums;
  DepthSums depths;
  PlaneMoments plane;
  PointMoments points;
  Eigen::Matrix3d bb = Eigen::Matrix3d::Zero();  // sum of b b^T, from plane
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

// Of n points z b, where b = ((u - c_x) / f_x, (v - c_y) / f_y, 1).
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
                const DepthNoise& noise, double trim, std::vector<Region>& regions) {
  for (const auto& [label, v, begin, end] : runs)
    sumMeasured(inverse.data() + static_cast<std::size_t>(v) * camera.width + begin,
                inverse.data() + inverse.size(), end - begin, begin, v, regions[label].sums);
  for (Region& r : regions) {
    r.plane = r.sums.moments();
    const PlaneMoments::Fit fit = r.plane.fit();
    r.fitted = fit.plane;
    if (!(r.plane.n > 0 && r.plane.d > 0)) continue;  // nothing of it is measured
    const double rms = std::sqrt(fit.sse / r.plane.n), depth = r.plane.n / r.plane.d;
    r.tolerance = trim * std::max(noise.ofInverseDepth(depth), rms);
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

// sigma_r^2: how far a single point may lie off a plane, Eq. (4).
double offsetVariance(const Eigen::Vector3d& normal, const Eigen::Vector3d& centroid,
                      const Intrinsics& camera, const SensorNoise& noise) {
  const double pixel_std = kFaithfulPixelStd * camera.width / kReferenceWidth;
  const Eigen::Matrix3d Sigma_C =
      pointCovariance(centroid, camera, pixel_std, kPaperDepthFactor * noise.ofInverseDepth(centroid.z()));
  return normal.dot(Sigma_C * normal);
}

// White noise with which neighbouring pixels would differ as much as with smooth noise. Only this tilts a
// narrow strip: the rest of their noise its pixels share.
SensorNoise noiseOfNeighbours(const ImageNoise& noise, double z) {
  SensorNoise white = noise;
  if (noise.correlation_px > 1)
    static_cast<DepthNoise&>(white) = noise.scaledTo(noise.ofInverseDepth(z) / noise.correlation_px, z);
  return white;
}

using Pixels = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
}

// Convex hull by monotone chain; the row extremes come sorted by v, then u. Exact: the coordinates are
// integers.
void pixelHull(const RowExtreme* row_extremes, int height, Pixels& points, Pixels& hull) {
  points.clear();
  hull.clear();
  for (int v = 0; v < height; ++v) {
    const auto [first, last] = row_extremes[v];
    if (first > last) continue;
    points.emplace_back(first, v);
    if (last > first) points.emplace_back(last, v);
  }
  if (points.size() < 3) {
    hull = points;
    return;
  }
  const auto chain = [&hull](auto begin, auto end) {
    const std::size_t base = hull.size();
    for (auto it = begin; it != end; ++it) {
      while (hull.size() >= base + 2 && cross(hull[hull.size() - 2], hull.back(), *it) <= 0) hull.pop_back();
      hull.push_back(*it);
    }
    hull.pop_back();  // the last point of one chain is the first of the other
  };
  chain(points.begin(), points.end());
  chain(points.rbegin(), points.rend());
}

// Drops the vertex whose loss costs the least area until at most n remain.
void simplify(Pixels& hull, std::size_t n) {
  while (hull.size() > n) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const double lost =
          std::abs(cross(hull[(i + hull.size() - 1) % hull.size()], hull[i], hull[(i + 1) % hull.size()]));
      if (lost < least) least = lost, best = i;
    }
    hull.erase(hull.begin() + best);
  }
}

// Perspective keeps convexity, so the hull of the pixels is the hull of the points on the plane.
ConvexHull hullInPlane(const Pixels& pixels, const Intrinsics& camera, const Segment& s, double rho) {
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

// Pixels that share one error, if noise is smooth: the integral of its correlation.
double correlatedPixels(const ImageNoise& noise) {
  return 180 * kDegree * noise.correlation_px * noise.correlation_px;
}

// How uncertain a segment is, by its plane fit (METHOD 7.3) or as the paper has it; chosen once.
using Uncertainty = Eigen::Matrix3d (*)(const Region& r, const Segment& s, double rho,
                                        const Intrinsics& camera, const ImageNoise& noise,
                                        const SegmentEstimationParams& params);

Eigen::Matrix3d paperUncertainty(const Region&, const Segment& s, double, const Intrinsics& camera,
                                 const ImageNoise& noise, const SegmentEstimationParams& params) {
  return paperCovariance(s.normal(), s.t, s.lambda, camera, params.paper_factor, noise);
}

Eigen::Matrix3d fullUncertainty(const Region& r, const Segment& s, double rho, const Intrinsics& camera,
                                const ImageNoise& noise, const SegmentEstimationParams& params) {
  const double correlated = std::max(scaledPixels(kCorrelatedPixels, camera), correlatedPixels(noise));
  const double independent = std::max(kMinIndependent, r.plane.n / correlated);
  const double std = noise.ofInverseDepth(s.t.z()), variance = std * std;
  Eigen::Matrix3d Sigma_m = (r.plane.n / independent) * variance * r.bb.inverse();  // METHOD 7.3
  Sigma_m.diagonal() +=
      Eigen::Array3d(noise.distortion_slope, noise.distortion_slope, noise.distortion_offset)
          .square()
          .matrix();
  Eigen::Matrix3d Sigma_q = slopeOffsetCovariance(s.R, s.t, rho, Sigma_m);
  Sigma_q += paperCovariance(s.normal(), s.t, s.lambda, camera, params.edge_factor, noise);
  Sigma_q.diagonal() +=
      Eigen::Array3d(params.slope_floor_deg * kDegree, params.slope_floor_deg * kDegree, params.offset_floor)
          .square()
          .matrix();
  return Sigma_q;
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
  explicit Buffers(const SegmentEstimationParams& params)
      : uncertainty(params.paper_uncertainty ? paperUncertainty : fullUncertainty) {}

  Uncertainty uncertainty;
  std::vector<float> inverse;  // depth
  std::vector<Run> runs;
  std::vector<Region> regions;  // by label
  std::vector<RowExtreme> row_extremes;
  Pixels points, hull;
  std::vector<Segment> found;
  std::vector<int> label_of, order;
  std::vector<double> share;

  bool makeSegment(Region& r, const Intrinsics& camera, const ImageNoise& noise,
                   const SegmentEstimationParams& params, double min_support, Segment& s);
};

// The segment of a region, or false if it fails one of the tests of METHOD 8.
bool SegmentEstimation::Buffers::makeSegment(Region& r, const Intrinsics& camera, const ImageNoise& noise,
                                             const SegmentEstimationParams& params, double min_support,
                                             Segment& s) {
  if (r.plane.n < min_support) return false;
  const Eigen::Vector3d m = r.plane.fit().plane.toSpace(camera);  // METHOD 5.1
  const double length = m.norm();
  if (!(length > 1e-6) || 1.0 / length < kMinPlaneDistance) return false;
  const Eigen::Vector3d n = m / length;
  const double rho = 1.0 / length;

  // Support points projected orthogonally onto the plane.
  const Eigen::Vector3d mean = r.points.p / r.points.n;
  const Eigen::Matrix3d in_plane = Eigen::Matrix3d::Identity() - n * n.transpose();
  const Eigen::Matrix3d C = in_plane * (r.points.pp / r.points.n - mean * mean.transpose()) * in_plane;
  s.t = mean - (n.dot(mean) - rho) * n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eig(C);
  Eigen::Vector3d x = eig.eigenvectors().col(2);
  x = (x - n * n.dot(x)).normalized();
  s.R << x, n.cross(x), n;
  s.lambda = {eig.eigenvalues()[2], std::max(0.0, eig.eigenvalues()[1])};
  s.num_points = static_cast<std::int32_t>(r.plane.n);

  const double width = std::sqrt(s.lambda[1]);
  const double nearest =
      s.t.z() - std::max(std::sqrt(s.lambda[0]) * std::abs(s.R(2, 0)), width * std::abs(s.R(2, 1)));
  if (nearest > params.max_depth || n.dot(s.t.normalized()) < params.min_incidence) return false;
  // A strip fixes its slope across only if it is wide compared with the noise, or with what furniture is made
  // of.
  const double noise_width =
      kWideInNoise * std::sqrt(offsetVariance(n, s.t, camera, noiseOfNeighbours(noise, s.t.z())));
  if (!(width >= std::min(params.min_width, noise_width))) return false;
  if (!(width * camera.fx / s.t.z() >= params.min_width_px)) return false;

  r.bb = rayMoments(r.plane, camera);
  s.Sigma_q = uncertainty(r, s, rho, camera, noise, params);
  if (!s.Sigma_q.allFinite() || s.Sigma_q.llt().info() != Eigen::Success) return false;
  pixelHull(r.row_extremes, camera.height, points, hull);
  simplify(hull, ConvexHull::kMaxVertices);
  s.hull = hullInPlane(hull, camera, s, rho);
  return s.hull.size >= 3 && s.hull.area() > 0;
}

Eigen::Matrix3d paperCovariance(const Eigen::Vector3d& normal, const Eigen::Vector3d& centroid,
                                const Eigen::Vector2d& lambda, const Intrinsics& camera, double kappa_u,
                                const SensorNoise& noise) {
  const double var_r = kappa_u * kappa_u * offsetVariance(normal, centroid, camera, noise);  // Eq. (4)
  return Eigen::Vector3d(var_r / (lambda[0] + var_r), var_r / (lambda[1] + var_r), var_r)
      .asDiagonal();  // Eq. (5)
}

Eigen::Matrix3d slopeOffsetCovariance(const Eigen::Matrix3d& R, const Eigen::Vector3d& t, double rho,
                                      const Eigen::Matrix3d& Sigma_m) {
  Eigen::Matrix3d J_q;
  J_q << R.col(0).transpose(), R.col(1).transpose(), -t.transpose();
  J_q *= rho;
  return J_q * Sigma_m * J_q.transpose();
}

SegmentEstimation::SegmentEstimation(const SegmentEstimationParams& params)
    : params_(params), buffers_(std::make_unique<Buffers>(params)) {}
SegmentEstimation::~SegmentEstimation() = default;
SegmentEstimation::SegmentEstimation(const SegmentEstimation& other) : SegmentEstimation(other.params_) {}
SegmentEstimation& SegmentEstimation::operator=(const SegmentEstimation& other) {
  params_ = other.params_;
  buffers_ = std::make_unique<Buffers>(params_);
  return *this;
}

void SegmentEstimation::estimate(const DepthImage& image, const LabelImage& labels, const ImageNoise& noise,
                                 std::vector<Segment>& segments, std::vector<int>& kept) {
  segments.clear();
  kept.clear();
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
  fitRegions(image.camera, b.inverse, b.runs, noise, params_.trim, b.regions);
  const double min_support = std::max(3.0, scaledPixels(params_.min_support, image.camera));
  gatherSupport(image, b.inverse, b.runs, min_support, b.regions, b.row_extremes);

  b.found.clear();
  b.label_of.clear();
  for (int label = 1; label <= max_label; ++label) {
    Segment s;
    if (!b.makeSegment(b.regions[label], image.camera, noise, params_, min_support, s)) continue;
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
                                      const ImageNoise& noise, const SegmentEstimationParams& params,
                                      std::vector<int>* kept) {
  std::vector<Segment> segments;
  std::vector<int> of_segments;
  SegmentEstimation(params).estimate(image, labels, noise, segments, of_segments);
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
