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
  // How many pixels the pictures share depends on the position and says nothing about it; what counts is how
  // the shared ones agree. Otherwise a bare corridor would be found where the overlap is largest.
  std::vector<DepthAgreement> found;
  int largest = 0;
  for (int i = -half; i <= half; ++i) {
    found.push_back(comparison.compareBoth(scene, model, at(centre + i * params.step), kCoarseColumns));
    largest = std::max(largest, found.back().judged());
  }
  constexpr double kEnoughShared = 0.25;  // of the largest overlap; fewer pixels agree by chance
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

  constexpr int kFineHalf = 5;  // fine steps on each side
  constexpr double kReach = 2;  // so far [coarse steps]: on the coarse grid the maximum may be a neighbour's
  std::vector<double> positions;
  for (const int i : maxima) {
    const double coarse = centre + (i - half) * params.step;
    struct Fine {
      double position;
      DepthAgreement agreement;
    };
    std::vector<Fine> fine;
    int most_shared = 1;
    for (int j = -kFineHalf; j <= kFineHalf; ++j) {
      const double position = coarse + j * kReach * params.step / kFineHalf;
      fine.push_back({position, comparison.compareBoth(scene, model, at(position), kFineColumns)});
      most_shared = std::max(most_shared, fine.back().agreement.judged());
    }
    double best_position = coarse, best_likelihood = -std::numeric_limits<double>::infinity();
    for (const auto& [position, a] : fine) {
      if (a.judged() < kEnoughShared * most_shared) continue;
      const double likelihood = a.likelihood / a.judged();
      if (likelihood > best_likelihood) best_likelihood = likelihood, best_position = position;
    }
    positions.push_back(best_position);
  }
  return positions;
}

}  // namespace facetloc::internal
