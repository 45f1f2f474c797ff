// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/depth_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace facetloc::internal {

std::vector<double> alignDepth(const DepthPicture& scene, const DepthPicture& model,
                               const Eigen::Isometry3d& T_m_c, const Eigen::Vector3d& direction,
                               double centre, const DepthComparison& comparison,
                               const DepthAlignmentParams& params) {
  if (scene.empty() || model.empty()) return {};
  const auto at = [&](double position) {
    Eigen::Isometry3d T = T_m_c;
    T.translation() += direction * (position - direction.dot(T_m_c.translation()));
    return T;
  };
  const int half = std::max(1, static_cast<int>(std::lround(params.range / params.step)));
  // The share of agreeing pixels among the shared ones is the evidence. Their number is none: it depends on
  // the position, and would place a view of a bare corridor where the overlap is largest.
  std::vector<DepthAgreement> found;
  int largest = 0;
  for (int i = -half; i <= half; ++i) {
    const Eigen::Isometry3d T = at(centre + i * params.step);
    found.push_back(comparison.count(scene, model, T, kCoarseColumns));
    found.back() += comparison.count(model, scene, T.inverse(), kCoarseColumns);
    largest = std::max(largest, found.back().judged());
  }
  constexpr double kEnoughShared = 0.25;  // share of the largest overlap; fewer pixels agree by chance
  std::vector<double> agreement;
  for (const DepthAgreement& a : found) {
    const double shared = std::max<double>(a.judged(), kEnoughShared * largest);
    agreement.push_back(largest > 0 ? largest * a.net() / shared : 0);
  }
  const double best = *std::max_element(agreement.begin(), agreement.end());
  const double mean = std::accumulate(agreement.begin(), agreement.end(), 0.0) / agreement.size();
  if (best - mean < params.prominence) return {};

  std::vector<int> maxima;
  for (int i = 1; i + 1 < static_cast<int>(agreement.size()); ++i)
    if (agreement[i] >= agreement[i - 1] && agreement[i] > agreement[i + 1] &&
        agreement[i] >= best - params.runner_up)
      maxima.push_back(i);
  std::stable_sort(maxima.begin(), maxima.end(), [&](int a, int b) { return agreement[a] > agreement[b]; });
  if (maxima.size() > 2) maxima.resize(2);

  const auto likeliest = [&](double around, double step, int steps_aside) {
    struct Step {
      double position;
      DepthAgreement agreement;
    };
    std::vector<Step> tried;
    int most_shared = 1;
    for (int j = -steps_aside; j <= steps_aside; ++j) {
      const double position = around + j * step;
      tried.push_back({position, comparison.compareBoth(scene, model, at(position), kFineColumns)});
      most_shared = std::max(most_shared, tried.back().agreement.judged());
    }
    double best_position = around, best_likelihood = -std::numeric_limits<double>::infinity();
    for (const auto& [position, a] : tried) {
      if (a.judged() < kEnoughShared * most_shared) continue;
      const double likelihood = a.likelihood / a.judged();
      if (likelihood > best_likelihood) best_likelihood = likelihood, best_position = position;
    }
    return best_position;
  };
  constexpr int kSteps = 2;     // to each side of a maximum, then one of half the size
  constexpr double kReach = 2;  // so far [coarse steps]: on the coarse grid the maximum may be a neighbour's
  const double step = kReach * params.step / (kSteps + 0.5);
  std::vector<double> positions;
  for (const int i : maxima) {
    const double near = likeliest(centre + (i - half) * params.step, step, kSteps);
    positions.push_back(likeliest(near, step / 2, 1));
  }
  return positions;
}

}  // namespace facetloc::internal
