// SPDX-License-Identifier: BSD-3-Clause
#include "depth/depth_consistency.h"

#include "depth/depth_difference.h"
#include "shared/lanes.h"

#include <algorithm>
#include <array>
#include <vector>

namespace facetloc::internal {
namespace {

// Bounded log likelihoods (METHOD 8.2): a contradiction is as bad as ln 0.02, an occlusion as ln 0.25.
constexpr float kContradicting = -3.912f;
constexpr float kOccluded = -1.386f;
constexpr double kUnitDepth = 3.479;  // at which an exact agreement counts 0 [m]
constexpr auto kNearest = static_cast<float>(DepthDifference::kNearest);
constexpr float kLn2 = 0.69314718f;
constexpr float kQuantum = static_cast<float>(DepthPicture::kQuantum);

}  // namespace

DepthAgreement DepthComparison::compare(const DepthPicture& a, const DepthPicture& b,
                                        const Eigen::Isometry3d& T_b_a, int columns) const {
  DepthAgreement sum;
  if (a.empty() || b.empty()) return sum;
  const DepthJudge judge(*this, a, b, T_b_a);
  const int step = gridStep(a, columns);
  std::array<int, 4> count{};
  DepthVerdicts verdicts;
  for (int v = step / 2; v < a.camera.height; v += step) {
    judge.row(v, step, verdicts, &sum.likelihood);
    for (const DepthVerdict verdict : verdicts) ++count[static_cast<int>(verdict)];
  }
  sum.agree = count[static_cast<int>(DepthVerdict::agree)];
  sum.contradict = count[static_cast<int>(DepthVerdict::contradict)];
  sum.occluded = count[static_cast<int>(DepthVerdict::occluded)];
  return sum;
}

DepthAgreement DepthComparison::compareBoth(const DepthPicture& a, const DepthPicture& b,
                                            const Eigen::Isometry3d& T_b_a, int columns) const {
  DepthAgreement sum = compare(a, b, T_b_a, columns);
  sum += compare(b, a, T_b_a.inverse(), columns);
  return sum;
}

namespace {

// Judges pixels u, u + step, ... of a row of picture a; the point of inverse depth rho on a ray b is
// (R b + t rho) / rho, so that everything stays in inverse depth. Adds the likelihoods to a sum.
FACETLOC_MULTIVERSION void judgePixels(const DepthJudge::Geometry& g, const std::uint16_t* row, int v, int u,
                                       int step, int n, DepthVerdict* out, double* likelihood) {
  const float row_x = g.down[0] * v + g.origin[0], row_y = g.down[1] * v + g.origin[1],
              row_z = g.down[2] * v + g.origin[2];
  Floats sum{};
  for (int i = 0; i < n; i += kLanes) {
    std::int32_t known[kLanes], smallest[kLanes], largest[kLanes], index[kLanes];
    for (int k = 0; k < kLanes; ++k) known[k] = row[u + std::min(i + k, n - 1) * step];
    Ints quanta, low, high;
    std::memcpy(&quanta, known, sizeof quanta);
    const Floats rho = __builtin_convertvector(quanta, Floats) * kQuantum;
    const Floats column = static_cast<float>(u + i * step) + kLaneOffset * static_cast<float>(step);
    const Floats px = g.across[0] * column + row_x + g.t[0] * rho;
    const Floats py = g.across[1] * column + row_y + g.t[1] * rho;
    const Floats pz = g.across[2] * column + row_z + g.t[2] * rho;
    const Floats inverse = 1.f / pz;
    const Floats x = g.fx * px * inverse + g.cx, y = g.fy * py * inverse + g.cy;
    Ints inside = (kLane < n - i) & (rho >= g.farthest) & (pz > kNearest * rho) & (x >= 1.f) & (y >= 1.f) &
                  (x < static_cast<float>(g.width - 1)) & (y < static_cast<float>(g.height - 1));
    const Ints where = __builtin_convertvector((Floats)((Ints)y & inside), Ints) * g.width +
                       __builtin_convertvector((Floats)((Ints)x & inside), Ints);
    std::memcpy(index, &where, sizeof index);
    for (int k = 0; k < kLanes; ++k) smallest[k] = g.lowest[index[k]], largest[k] = g.highest[index[k]];
    std::memcpy(&low, smallest, sizeof low);
    std::memcpy(&high, largest, sizeof high);
    inside &= high != 0;

    const Floats predicted = rho * inverse, none{};
    const Floats below = predicted - __builtin_convertvector(low, Floats) * kQuantum;
    const Floats above = predicted - __builtin_convertvector(high, Floats) * kQuantum;
    const Floats difference = below < 0.f ? below : above > 0.f ? above : none;
    const Floats error = g.absolute_error + g.relative_error * predicted;
    const Ints contradicts = difference > g.gate * error, hides = difference < -g.gate * error;
    constexpr Ints kAgree = Ints{} + int(DepthVerdict::agree),
                   kContradict = Ints{} + int(DepthVerdict::contradict),
                   kOcclude = Ints{} + int(DepthVerdict::occluded);
    const Ints verdict = inside & (contradicts ? kContradict : hides ? kOcclude : kAgree);
    const Chars codes = __builtin_convertvector(verdict, Chars);
    std::memcpy(out + i, &codes, std::min(kLanes, n - i));
    if (!likelihood) continue;

    // The logarithm of x = 2^e (1 + f) with f in [-0.25, 0.5], to 1e-6: ln(1 + f) = 2 artanh(f / (2 + f)).
    const Floats argument = inside ? error * (1 / g.unit_error) : none + 1.f;
    const Ints exponent = (((Ints)argument + 0x00400000) >> 23) - 127;
    const Floats f = (Floats)((Ints)argument - (exponent << 23)) - 1.f;
    const Floats s = f / (2.f + f), s2 = s * s;
    const Floats log_error = __builtin_convertvector(exponent, Floats) * kLn2 +
                             2.f * s * (1.f + s2 * (1.f / 3 + s2 * (1.f / 5 + s2 * (1.f / 7))));
    const Floats ratio = difference / error;
    const Floats gaussian = -log_error - 0.5f * ratio * ratio, contradiction = none + kContradicting,
                 occlusion = none + kOccluded;
    const Floats agreement = gaussian > kContradicting ? gaussian : contradiction;
    const Floats counts = contradicts ? contradiction : hides ? occlusion : agreement;
    sum += inside ? counts : none;
  }
  if (likelihood)
    for (int k = 0; k < kLanes; ++k) *likelihood += sum[k];
}

}  // namespace

DepthJudge::DepthJudge(const DepthComparison& comparison, const DepthPicture& a, const DepthPicture& b,
                       const Eigen::Isometry3d& T_b_a)
    : a_(a) {
  const Eigen::Matrix3d R = T_b_a.linear();
  const Eigen::Vector3d across = R.col(0) / a.camera.fx, down = R.col(1) / a.camera.fy,
                        origin = R.col(2) - a.camera.cx * across - a.camera.cy * down;
  for (int i = 0; i < 3; ++i) {
    g_.across[i] = static_cast<float>(across[i]), g_.down[i] = static_cast<float>(down[i]);
    g_.origin[i] = static_cast<float>(origin[i]), g_.t[i] = static_cast<float>(T_b_a.translation()[i]);
  }
  // Pixel i covers [i, i + 1) after this shift.
  g_.fx = static_cast<float>(b.camera.fx), g_.cx = static_cast<float>(b.camera.cx + 0.5);
  g_.fy = static_cast<float>(b.camera.fy), g_.cy = static_cast<float>(b.camera.cy + 0.5);
  g_.width = b.camera.width, g_.height = b.camera.height;
  g_.lowest = b.lowest.data(), g_.highest = b.highest.data();
  g_.farthest = static_cast<float>(comparison.farthest());
  const DepthErrors errors = comparison.errorsBetween(a, b);
  g_.absolute_error = static_cast<float>(errors.absolute);
  g_.relative_error = static_cast<float>(errors.relative);
  g_.unit_error = static_cast<float>(errors.of(1 / kUnitDepth));
  g_.gate = static_cast<float>(errors.gate);
}

void DepthJudge::row(int v, int step, DepthVerdicts& out, double* likelihood) const {
  const int first = step / 2, width = a_.camera.width;
  out.resize(gridPoints(width, step));
  judgePixels(g_, a_.inverse_depth.data() + static_cast<std::size_t>(v) * width, v, first, step,
              static_cast<int>(out.size()), out.data(), likelihood);
}

DepthVerdict DepthJudge::operator()(int u, int v) const {
  DepthVerdict verdict;
  judgePixels(g_, a_.inverse_depth.data() + static_cast<std::size_t>(v) * a_.camera.width, v, u, 1, 1,
              &verdict, nullptr);
  return verdict;
}

}  // namespace facetloc::internal
