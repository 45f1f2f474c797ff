// SPDX-License-Identifier: BSD-3-Clause
#include "depth/depth_consistency.h"

#include "base/lanes.h"
#include "depth/depth_difference.h"

#include <algorithm>

namespace facetloc::internal {
namespace {

// Bounded log likelihoods (METHOD 8.2): a contradiction is as bad as ln 0.02, an occlusion as ln 0.25.
constexpr float kContradicting = -3.912f;
constexpr float kOccluded = -1.386f;
constexpr double kUnitDepth = 3.479;  // at which an exact agreement counts 0 [m]
constexpr auto kNearest = static_cast<float>(DepthDifference::kNearest);
constexpr float kLn2 = 0.69314718f;
constexpr float kQuantum = static_cast<float>(DepthPicture::kQuantum);

// The pixels on a grid, row by row.
template <void (DepthComparator::*kAddRow)(int, int, DepthAgreement&) const>
DepthAgreement sumOf(const DepthComparison& comparison, const DepthPicture& a, const DepthPicture& b,
                     const Eigen::Isometry3d& T_b_a, int columns) {
  DepthAgreement sum;
  if (a.empty() || b.empty()) return sum;
  const DepthComparator judge(comparison, a, b, T_b_a);
  const int step = gridStep(a, columns);
  for (int v = step / 2; v < a.camera.height; v += step) (judge.*kAddRow)(v, step, sum);
  return sum;
}

/** Neighbouring pixels compared with another picture. */
struct Judged {
  Ints inside, contradicts, hides;  // the last two also of pixels that are not inside
  Floats difference, error;         // difference of inverse depths and its error [1/m]
};

// Judges pixels u, u + step, ... of a row of picture a; the point of inverse depth rho on a ray b is
// (R b + t rho) / rho, so that everything stays in inverse depth.
FACETLOC_ALWAYS_INLINE void judgeLanes(const DepthComparator::Geometry& g, const float (&start)[3],
                                       const std::uint16_t* row, int u, int step, int n, int i, Judged& out) {
  Floats column, rho, p[3];
  readPixels(row, u, step, n, i, column, rho);
  g.rays.along(start, column, p);
  for (int k = 0; k < 3; ++k) p[k] += g.t[k] * rho;
  const Floats inverse = 1.f / p[2], x = g.fx * p[0] * inverse + g.cx, y = g.fy * p[1] * inverse + g.cy;
  Ints inside = (kLane < n - i) & (rho >= g.farthest) & (p[2] > kNearest * rho), at_u, at_v;
  findPixels(x, y, g.width, g.height, 1, inside, at_u, at_v);
  const Ints at = at_v * g.width + at_u;
  std::int32_t both[kLanes];
  for (int k = 0; k < kLanes; ++k) std::memcpy(&both[k], g.extremes + at[k], sizeof both[k]);
  Ints extremes;
  std::memcpy(&extremes, both, sizeof extremes);
  const Ints low = extremes & 0xffff, high = (extremes >> 16) & 0xffff;
  out.inside = inside & (high != 0);

  const Floats predicted = rho * inverse, none{};
  const Floats below = predicted - __builtin_convertvector(low, Floats) * kQuantum;
  const Floats above = predicted - __builtin_convertvector(high, Floats) * kQuantum;
  out.difference = below < 0.f ? below : above > 0.f ? above : none;
  out.error = g.absolute_error + g.relative_error * predicted + g.squared_error * predicted * predicted;
  out.contradicts = out.difference > g.gate * out.error;
  out.hides = out.difference < -g.gate * out.error;
}

struct Counts {
  Ints agree{}, contradict{}, occluded{};  // negative: a comparison that holds is -1

  FACETLOC_ALWAYS_INLINE void add(const Judged& judged) {
    agree += judged.inside & ~judged.contradicts & ~judged.hides;
    contradict += judged.inside & judged.contradicts;
    occluded += judged.inside & judged.hides;
  }
  FACETLOC_ALWAYS_INLINE void addTo(DepthAgreement& sum) const {
    for (int k = 0; k < kLanes; ++k)
      sum.agree -= agree[k], sum.contradict -= contradict[k], sum.occluded -= occluded[k];
  }
};

FACETLOC_MULTIVERSION void judgePixels(const DepthComparator::Geometry& g, const std::uint16_t* row, int v,
                                       int u, int step, int n, DepthLabel* out) {
  float start[3];
  g.rays.startRow(v, start);
  for (int i = 0; i < n; i += kLanes) {
    Judged judged;
    judgeLanes(g, start, row, u, step, n, i, judged);
    constexpr Ints kAgree = Ints{} + int(DepthLabel::agree),
                   kContradict = Ints{} + int(DepthLabel::contradict),
                   kOcclude = Ints{} + int(DepthLabel::occluded);
    const Ints verdict = judged.inside & (judged.contradicts ? kContradict
                                          : judged.hides     ? kOcclude
                                                             : kAgree);
    const Chars codes = __builtin_convertvector(verdict, Chars);
    std::memcpy(out + i, &codes, std::min(kLanes, n - i));
  }
}

FACETLOC_MULTIVERSION void countPixels(const DepthComparator::Geometry& g, const std::uint16_t* row, int v,
                                       int u, int step, int n, DepthAgreement& total) {
  float start[3];
  g.rays.startRow(v, start);
  Counts counts;
  for (int i = 0; i < n; i += kLanes) {
    Judged judged;
    judgeLanes(g, start, row, u, step, n, i, judged);
    counts.add(judged);
  }
  counts.addTo(total);
}

FACETLOC_MULTIVERSION void addPixels(const DepthComparator::Geometry& g, const std::uint16_t* row, int v,
                                     int u, int step, int n, DepthAgreement& total) {
  float start[3];
  g.rays.startRow(v, start);
  Counts counts;
  Floats sum{}, misfit{};
  for (int i = 0; i < n; i += kLanes) {
    Judged judged;
    judgeLanes(g, start, row, u, step, n, i, judged);
    counts.add(judged);
    const auto& [inside, contradicts, hides, difference, error] = judged;

    // The logarithm of x = 2^e (1 + f) with f in [-0.25, 0.5], to 1e-6: ln(1 + f) = 2 artanh(f / (2 + f)).
    const Floats none{}, argument = inside ? error * (1 / g.unit_error) : none + 1.f;
    const Ints exponent = (((Ints)argument + 0x00400000) >> 23) - 127;
    const Floats f = (Floats)((Ints)argument - (exponent << 23)) - 1.f;
    const Floats s = f / (2.f + f), s2 = s * s;
    const Floats log_error = __builtin_convertvector(exponent, Floats) * kLn2 +
                             2.f * s * (1.f + s2 * (1.f / 3 + s2 * (1.f / 5 + s2 * (1.f / 7))));
    const Floats ratio = difference / error;
    const Floats half_squared = 0.5f * ratio * ratio;
    const Floats gaussian = -log_error - half_squared, contradiction = none + kContradicting,
                 occlusion = none + kOccluded;
    const Floats agreement = gaussian > kContradicting ? gaussian : contradiction;
    const Floats counted = contradicts ? contradiction : hides ? occlusion : agreement;
    sum += inside ? counted : none;
    const Floats bounded = half_squared < -kContradicting ? half_squared : -contradiction;
    const Floats missed = contradicts ? -contradiction : hides ? -occlusion : bounded;
    misfit += inside ? missed : none;
  }
  counts.addTo(total);
  for (int k = 0; k < kLanes; ++k) total.likelihood += sum[k], total.misfit += misfit[k];
}

}  // namespace

DepthAgreement DepthComparison::compare(const DepthPicture& a, const DepthPicture& b,
                                        const Eigen::Isometry3d& T_b_a, int columns) const {
  return sumOf<&DepthComparator::add>(*this, a, b, T_b_a, columns);
}

DepthAgreement DepthComparison::compareBoth(const DepthPicture& a, const DepthPicture& b,
                                            const Eigen::Isometry3d& T_b_a, int columns) const {
  DepthAgreement sum = compare(a, b, T_b_a, columns);
  return sum += compare(b, a, T_b_a.inverse(), columns);
}

DepthAgreement DepthComparison::count(const DepthPicture& a, const DepthPicture& b,
                                      const Eigen::Isometry3d& T_b_a, int columns) const {
  return sumOf<&DepthComparator::count>(*this, a, b, T_b_a, columns);
}

int DepthComparison::pixelsInReach(const DepthPicture& picture, int columns) const {
  const int step = gridStep(picture, columns);
  const auto least = static_cast<int>(farthest() / DepthPicture::kQuantum);
  int n = 0;
  for (int v = step / 2; v < picture.camera.height; v += step)
    for (int u = step / 2; u < picture.camera.width; u += step)
      n += picture.inverse_depth[static_cast<std::size_t>(v) * picture.camera.width + u] > least;
  return n;
}

DepthComparator::DepthComparator(const DepthComparison& comparison, const DepthPicture& a,
                                 const DepthPicture& b, const Eigen::Isometry3d& T_b_a)
    : a_(a) {
  g_.rays = raysOf(a.camera, T_b_a.linear());
  for (int k = 0; k < 3; ++k) g_.t[k] = static_cast<float>(T_b_a.translation()[k]);
  // Pixel i covers [i, i + 1) after this shift.
  g_.fx = static_cast<float>(b.camera.fx), g_.cx = static_cast<float>(b.camera.cx + 0.5);
  g_.fy = static_cast<float>(b.camera.fy), g_.cy = static_cast<float>(b.camera.cy + 0.5);
  g_.width = b.camera.width, g_.height = b.camera.height;
  g_.extremes = b.extremes.data();
  g_.farthest = static_cast<float>(comparison.farthest());
  const DepthErrors errors = comparison.errorsBetween(a, b);
  g_.absolute_error = static_cast<float>(errors.absolute);
  g_.relative_error = static_cast<float>(errors.relative);
  g_.squared_error = static_cast<float>(errors.squared);
  g_.unit_error = static_cast<float>(errors.of(1 / kUnitDepth));
  g_.gate = static_cast<float>(errors.gate);
}

const std::uint16_t* DepthComparator::pixels(int v) const {
  return a_.inverse_depth.data() + static_cast<std::size_t>(v) * a_.camera.width;
}

void DepthComparator::row(int v, int step, DepthLabels& out) const {
  out.resize(gridPoints(a_.camera.width, step));
  judgePixels(g_, pixels(v), v, step / 2, step, static_cast<int>(out.size()), out.data());
}

void DepthComparator::count(int v, int step, DepthAgreement& sum) const {
  countPixels(g_, pixels(v), v, step / 2, step, gridPoints(a_.camera.width, step), sum);
}

void DepthComparator::add(int v, int step, DepthAgreement& sum) const {
  addPixels(g_, pixels(v), v, step / 2, step, gridPoints(a_.camera.width, step), sum);
}

DepthLabel DepthComparator::operator()(int u, int v) const {
  DepthLabel verdict;
  judgePixels(g_, pixels(v), v, u, 1, 1, &verdict);
  return verdict;
}

}  // namespace facetloc::internal
