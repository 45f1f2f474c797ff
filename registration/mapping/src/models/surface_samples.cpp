// SPDX-License-Identifier: BSD-3-Clause
#include "models/surface_samples.h"

#include "base/median.h"
#include "models/cube_view.h"
#include "threads/in_parallel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr int kPositions = 1500;        // spread over the bounds, those in walls and outside included
constexpr std::size_t kMostUsed = 400;  // positions inside the surface
constexpr int kSide = 16;               // width of each face of a cube [px]
constexpr double kFlat = 0.02;          // distance of a pixel from the plane of its neighbours, of its depth
constexpr double kSurrounded = 0.5;     // share of the directions in which the surface is met, inside
constexpr double kOpen = 0.2;           // ... of a surface that surrounds nothing
constexpr double kFewestInside = 0.01;  // share of the positions that are inside, unless it is open
constexpr double kNarrow = 0.25;        // share of the usual distance: inside a wall or a cupboard

/** Element i of the Halton sequence, between 0 and 1. */
double radicalInverse(int i, int base) {
  double value = 0, digit = 1;
  for (; i > 0; i /= base) digit /= base, value += digit * (i % base);
  return value;
}

/** The surface as seen from one position. */
struct Surroundings {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<SurfaceSample> samples;
  double known = 0;     // share of the directions
  double distance = 0;  // median
};

/** The plane through the pixels around one, seen from its camera; false where pixels are missing. */
bool planeAt(const DepthImage& face, int u, int v, SurfaceSample& sample) {
  const auto pointAt = [&](int x, int y) {
    return Eigen::Vector3d(static_cast<double>(face.at(x, y)) * face.camera.ray(x, y));
  };
  for (const auto& [x, y] : {std::pair(u, v), {u - 1, v}, {u + 1, v}, {u, v - 1}, {u, v + 1}})
    if (!isMeasured(face.at(x, y))) return false;
  const Eigen::Vector3d p = pointAt(u, v), left = pointAt(u - 1, v), up = pointAt(u, v - 1);
  Eigen::Vector3d normal = (pointAt(u + 1, v) - left).cross(pointAt(u, v + 1) - up);
  if (!(normal.norm() > 0)) return false;
  normal.normalize();
  const double off = kFlat * p.norm();
  if (std::abs(normal.dot(left - p)) > off || std::abs(normal.dot(up - p)) > off) return false;
  sample.point = p.cast<float>();
  sample.normal = (normal.dot(p) > 0 ? -normal : normal).cast<float>();
  return true;
}

Surroundings lookedAt(const Surface& surface, const Eigen::Vector3d& position) {
  Surroundings seen;
  seen.position = position;
  std::vector<double> distances;
  double all = 0, known = 0;
  lookAround(surface, Eigen::Isometry3d::Identity(), position, kSide,
             [&](const Eigen::Isometry3d& T_w_c, const DepthImage& face) {
               for (int v = 0; v < kSide; ++v)
                 for (int u = 0; u < kSide; ++u) {
                   const double length = face.camera.ray(u, v).norm();
                   const double solid_angle = 1 / (length * length * length);
                   all += solid_angle;
                   if (!isMeasured(face.at(u, v))) continue;
                   known += solid_angle;
                   distances.push_back(face.at(u, v) * length);
                   SurfaceSample sample;
                   if (u == 0 || v == 0 || u == kSide - 1 || v == kSide - 1 || !planeAt(face, u, v, sample))
                     continue;
                   sample.point = (T_w_c * sample.point.cast<double>()).cast<float>();
                   sample.normal = T_w_c.linear().cast<float>() * sample.normal;
                   sample.weight = static_cast<float>(solid_angle);
                   seen.samples.push_back(sample);
                 }
             });
  seen.known = known / all;
  if (!distances.empty()) seen.distance = median(distances);
  return seen;
}

void keep(std::vector<Surroundings>& all, const std::function<bool(const Surroundings&)>& isKept) {
  all.erase(std::remove_if(all.begin(), all.end(), [&](const Surroundings& s) { return !isKept(s); }),
            all.end());
}

double usualDistance(const std::vector<Surroundings>& all) {
  std::vector<double> distances;
  for (const Surroundings& s : all) distances.push_back(s.distance);
  return median(distances);
}

}  // namespace

SurfaceSamples samplesFromInside(const Surface& surface, int threads) {
  SurfaceSamples out;
  const Eigen::AlignedBox3d bounds = surface.bounds();
  if (bounds.isEmpty()) return out;
  std::vector<Surroundings> seen(kPositions);
  forEachInParallel(kPositions, threads, [&](int i) {
    const Eigen::Vector3d share(radicalInverse(i + 1, 2), radicalInverse(i + 1, 3), radicalInverse(i + 1, 5));
    seen[static_cast<std::size_t>(i)] = lookedAt(surface, bounds.min() + share.cwiseProduct(bounds.sizes()));
  });
  const auto inside =
      std::count_if(seen.begin(), seen.end(), [](const Surroundings& s) { return s.known >= kSurrounded; });
  const double least = static_cast<double>(inside) >= kFewestInside * kPositions ? kSurrounded : kOpen;
  keep(seen, [&](const Surroundings& s) { return s.known >= least; });
  if (seen.empty()) return out;
  out.distance = usualDistance(seen);
  keep(seen, [&](const Surroundings& s) { return s.distance >= kNarrow * out.distance; });
  seen.resize(std::min(seen.size(), kMostUsed));
  double all = 0;
  for (const Surroundings& s : seen) {
    out.positions.push_back(s.position);
    out.samples.insert(out.samples.end(), s.samples.begin(), s.samples.end());
    for (const SurfaceSample& sample : s.samples) all += sample.weight;
  }
  for (SurfaceSample& sample : out.samples) sample.weight /= static_cast<float>(all);
  return out;
}

}  // namespace facetloc::internal
