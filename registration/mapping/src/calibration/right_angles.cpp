// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/flat_surfaces.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace facetloc::internal {
namespace {

constexpr double kLeastAngle = 30 * kDegree;  // between surfaces of a pair
constexpr double kSharp = 1.5 * kDegree;      // about a right angle
constexpr double kLeastShare = 0.025;         // least share of the image of a surface
constexpr std::size_t kLeastPairs = 30;

/** Two surfaces of one image. */
struct SurfacePair {
  std::size_t image;
  Eigen::Vector3d a, b;  // m of their planes, as read
  double weight;
};

/** Logarithms of the factors of fx and fy, and displacement of the centre as a ray. */
using Change = std::array<double, 4>;

Eigen::Vector3d changed(const Eigen::Vector3d& m, const Change& c) {
  const double x = m.x() * std::exp(c[0]), y = m.y() * std::exp(c[1]);
  return {x, y, m.z() - x * c[2] - y * c[3]};
}

std::vector<SurfacePair> pairsOf(const std::vector<FlatSurface>& surfaces) {
  std::vector<SurfacePair> pairs;
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    for (std::size_t j = i + 1; j < surfaces.size() && surfaces[j].image == surfaces[i].image; ++j) {
      const FlatSurface &a = surfaces[i], &b = surfaces[j];
      if (std::min(a.share, b.share) < kLeastShare) continue;
      const Eigen::Vector3d m = a.plane.normalized(), n = b.plane.normalized();
      if (std::abs(m.dot(n)) < std::cos(kLeastAngle))
        pairs.push_back({a.image, m, n, std::min(a.share, b.share)});
    }
  return pairs;
}

/** Share of the pairs that are perpendicular. */
double shareOf(const std::vector<SurfacePair>& pairs, const Change& change) {
  double sum = 0, all = 0;
  for (const SurfacePair& p : pairs) {
    const double sharp = changed(p.a, change).normalized().dot(changed(p.b, change).normalized()) / kSharp;
    sum += p.weight * std::exp(-sharp * sharp / 2);
    all += p.weight;
  }
  return all > 0 ? sum / all : 0;
}

/** The share, less a little for unusual changes: many changes make right angles of few pairs. */
double worthOf(const std::vector<SurfacePair>& pairs, const Change& c) {
  constexpr double kFocal = 0.5, kOblong = 0.2, kCentre = 0.1, kLittle = 0.01;
  const auto squared = [](double x) { return x * x; };
  return shareOf(pairs, c) -
         kLittle * (squared(c[0] / kFocal) + squared(c[1] / kFocal) + squared((c[0] - c[1]) / kOblong) +
                    squared(c[2] / kCentre) + squared(c[3] / kCentre));
}

/** Climbs in ever shorter steps. */
Change climbed(const std::vector<SurfacePair>& pairs, Change at) {
  double worth = worthOf(pairs, at);
  for (double step = 0.06; step > 0.001; step /= 2)
    for (bool better = true; better;) {
      better = false;
      for (std::size_t k = 0; k < 5; ++k)
        for (const double d : {step, -step}) {
          Change next = at;
          if (k == 4)
            next[0] += d, next[1] += d;
          else
            next[k] += k < 2 ? d : d / 2;
          if (const double w = worthOf(pairs, next); w > worth) at = next, worth = w, better = true;
        }
    }
  return at;
}

Change best(const std::vector<SurfacePair>& pairs) {
  constexpr double kFarthest = 0.8, kStep = 0.05, kMostOblong = 0.6, kOblongStep = 0.1;
  Change start{};
  double most = worthOf(pairs, start);
  for (double focal = -kFarthest; focal <= kFarthest; focal += kStep)
    for (double oblong = -kMostOblong; oblong <= kMostOblong; oblong += kOblongStep) {
      const Change at{focal + oblong / 2, focal - oblong / 2, 0, 0};
      if (const double w = worthOf(pairs, at); w > most) start = at, most = w;
    }
  return climbed(pairs, start);
}

/** Standard deviation of the best change, by drawing the images anew. */
Change deviationOf(const std::vector<SurfacePair>& pairs, const Change& at) {
  constexpr int kDraws = 16;
  std::vector<std::vector<SurfacePair>> of_images;
  for (const SurfacePair& p : pairs) {
    if (of_images.empty() || of_images.back().front().image != p.image) of_images.emplace_back();
    of_images.back().push_back(p);
  }
  std::mt19937 random(1);
  Change squares{};
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<SurfacePair> drawn;
    for (std::size_t i = 0; i < of_images.size(); ++i) {
      const auto& image = of_images[random() % of_images.size()];
      drawn.insert(drawn.end(), image.begin(), image.end());
    }
    const Change found = climbed(drawn, at);
    for (std::size_t k = 0; k < 4; ++k) squares[k] += (found[k] - at[k]) * (found[k] - at[k]) / kDraws;
  }
  for (double& s : squares) s = std::sqrt(s);
  return squares;
}

}  // namespace

std::optional<RightAngles> rightAngles(const FlatSurfaces& flat, const Intrinsics& camera) {
  const std::vector<SurfacePair> pairs = pairsOf(flat.surfaces);
  if (pairs.size() < kLeastPairs) return {};
  const Change change = best(pairs), std = deviationOf(pairs, change);
  RightAngles found;
  found.pairs = pairs.size();
  found.share_as_given = shareOf(pairs, {});
  found.share_by_best = shareOf(pairs, change);
  found.fx = std::exp(change[0]), found.fy = std::exp(change[1]);
  found.cx = -change[2] * found.fx * camera.fx, found.cy = -change[3] * found.fy * camera.fy;
  found.fx_std = found.fx * std[0], found.fy_std = found.fy * std[1];
  found.cx_std = std[2] * found.fx * camera.fx, found.cy_std = std[3] * found.fy * camera.fy;
  return found;
}

}  // namespace facetloc::internal
