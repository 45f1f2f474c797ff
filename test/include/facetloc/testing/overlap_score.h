// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/io/png.h>

#include <map>
#include <utility>

namespace facetloc::test {

/** \brief Regions of the truth and how many of them were segmented correctly, by the criterion of the SegComp
 * benchmark (Hoover et al. 1996): one segment covers at least 80 % of the region and is covered by it to at
 * least 80 %. */
struct OverlapScore {
  int regions = 0;
  int correct = 0;
  int segments = 0;

  OverlapScore& operator+=(const OverlapScore& o) {
    regions += o.regions, correct += o.correct, segments += o.segments;
    return *this;
  }
  double rate() const { return regions ? correct / static_cast<double>(regions) : 0; }
  double precision() const { return segments ? correct / static_cast<double>(segments) : 0; }
};

/** \brief Scores labels against a truth in which values from first_plane on are planar regions; smaller
 * regions than min_region pixels do not count. */
inline OverlapScore overlapScore(const LabelImage& found, const Raster<std::uint16_t>& truth,
                                 int first_plane = 10, int min_region = 100) {
  constexpr double kOverlap = 0.8;
  std::map<int, int> size_true, size_found;
  std::map<std::pair<int, int>, int> shared;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    const int t = truth.data[i], f = found.label[i];
    if (t >= first_plane) ++size_true[t];
    if (f) ++size_found[f];
    if (t >= first_plane && f) ++shared[{t, f}];
  }
  OverlapScore score;
  score.segments = static_cast<int>(size_found.size());
  for (const auto& [t, size] : size_true) score.regions += size >= min_region;
  for (const auto& [pair, n] : shared)
    if (size_true[pair.first] >= min_region && n >= kOverlap * size_true[pair.first] &&
        n >= kOverlap * size_found[pair.second])
      ++score.correct;
  return score;
}

}  // namespace facetloc::test
