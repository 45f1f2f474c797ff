// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/tie_search.h"

#include "shortlist/plane_triplet_matcher.h"

#include <facetloc/localization/place_index.h>

#include <algorithm>
#include <cmath>

namespace facetloc::internal {
namespace {

constexpr int kMostSimilar = 15;    // earlier keyframes that one is compared with for their likeness
constexpr int kClose = 10;          // numbers of keyframes that are compared whatever they show
constexpr int kIndexed = 100;       // earlier keyframes by the index whose planes are overlaid
constexpr int kIndexAligned = 300;  // those that the index aligns with a view
constexpr double kSigmas = 3;

/** Lists the earlier keyframes of other parts whose planes are overlaid with a keyframe's: all, or the most
 * similar ones by an index. */
class EarlierKeyframes {
public:
  EarlierKeyframes(const std::vector<TrajectoryNode>& keyframes, int first, const TieSearch& search)
      : keyframes_(keyframes) {
    const auto n = static_cast<long long>(keyframes.size());
    if (search.mounting && (n - first) * (n + first) / 2 > search.exhaustive_up_to)
      makeIndex(*search.mounting);
  }

  std::vector<int> of(int b) const {
    const auto isExcluded = [&](int a) { return a >= b || keyframes_[a].part == keyframes_[b].part; };
    std::vector<int> earlier;
    if (index_) {
      for (const ShortlistedModel& found : index_->candidates(*keyframes_[b].view, kIndexed, isExcluded))
        earlier.push_back(found.model);
      std::sort(earlier.begin(), earlier.end());
      return earlier;
    }
    for (int a = 0; a < b; ++a)
      if (!isExcluded(a)) earlier.push_back(a);
    return earlier;
  }

private:
  void makeIndex(const CameraMounting& mounting) {
    Map map;
    map.camera.mounting = mounting;
    for (const TrajectoryNode& k : keyframes_) map.models.emplace_back().setView(k.view);
    ShortlistParams params;
    params.aligned_models = kIndexAligned;
    index_.emplace(map, params);
  }

  const std::vector<TrajectoryNode>& keyframes_;
  std::optional<PlaceIndex> index_;
};

std::vector<int> mostSimilar(const std::vector<TrajectoryNode>& keyframes,
                             const std::vector<PlaneColumns>& planes, const EarlierKeyframes& earlier, int b,
                             const PoseWithCovariance& prior) {
  const PlaneTripletMatcher overlay(*keyframes[b].view, prior);
  if (!overlay.isUseful()) return {};
  std::vector<std::pair<float, int>> similar;
  for (const int a : earlier.of(b)) {
    const Overlay laid = overlay.on(planes[a]);
    if (laid.exists()) similar.emplace_back(-laid.score, a);
  }
  std::sort(similar.begin(), similar.end());
  std::vector<int> best;
  for (std::size_t i = 0; i < std::min<std::size_t>(kMostSimilar, similar.size()); ++i)
    best.push_back(similar[i].second);
  return best;
}

}  // namespace

std::vector<std::pair<int, int>> tieCandidates(const std::vector<TrajectoryNode>& keyframes, int first,
                                               const TieSearch& search) {
  const int n = static_cast<int>(keyframes.size());
  const int part = keyframes.empty() ? 0 : keyframes.front().part;
  if (std::all_of(keyframes.begin(), keyframes.end(),
                  [part](const TrajectoryNode& k) { return k.part == part; }))
    return {};
  if (search.work.progress) search.work.progress(0);
  std::vector<PlaneColumns> planes;
  for (const TrajectoryNode& k : keyframes) planes.emplace_back(*k.view);
  const EarlierKeyframes earlier(keyframes, first, search);
  std::vector<std::vector<int>> partners(n - first);
  const auto findPartners = [&](int i) {
    std::vector<int>& of_b = partners[i];
    const int b = first + i;
    of_b = mostSimilar(keyframes, planes, earlier, b, search.prior);
    for (int a = std::max(0, b - kClose); a < b; ++a)
      if (keyframes[a].part != keyframes[b].part) of_b.push_back(a);
    std::sort(of_b.begin(), of_b.end());
    of_b.erase(std::unique(of_b.begin(), of_b.end()), of_b.end());
  };
  search.work.forEach(n - first, findPartners);
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < n - first; ++i)
    for (const int a : partners[i]) pairs.emplace_back(a, first + i);
  return pairs;
}

TravelBound::TravelBound(const std::vector<TrajectoryNode>& keyframes, const CameraSpeed& speed,
                         const GraphCovariance& graph)
    : keyframes_(keyframes), speed_(speed), graph_(graph) {}

// Keyframes of the two parts, nearest in time; (-1, -1) if the camera was interrupted between all of them.
std::pair<int, int> TravelBound::nearestInTime(int part_a, int part_b) const {
  std::pair<int, int> nearest{-1, -1};
  double least = 0;
  int latest_a = -1, latest_b = -1;
  for (int k = 0; k < static_cast<int>(keyframes_.size()); ++k) {
    if (keyframes_[k].part == part_a) latest_a = k;
    if (keyframes_[k].part == part_b) latest_b = k;
    const bool is_of_either = k == latest_a || k == latest_b;
    if (!is_of_either || latest_a < 0 || latest_b < 0 || keyframes_[latest_a].run != keyframes_[latest_b].run)
      continue;
    const double duration = std::abs(keyframes_[latest_a].stamp - keyframes_[latest_b].stamp);
    if (nearest.first >= 0 && duration >= least) continue;
    nearest = {latest_a, latest_b};
    least = duration;
  }
  return nearest;
}

// Largest distance of the camera's motion between two keyframes: the known displacements of the parts in
// between, and the distance that its speed allows from one to the next.
double TravelBound::farthest(int first, int last) const {
  const auto positionOf = [&](int k) { return keyframes_[k].T_w_c.T.translation(); };
  double sum = 0;
  int begin = first;
  for (int k = first + 1; k <= last; ++k) {
    if (keyframes_[k].part == keyframes_[k - 1].part) continue;
    sum += (positionOf(k - 1) - positionOf(begin)).norm() +
           speed_.farthest(keyframes_[k].stamp - keyframes_[k - 1].stamp);
    begin = k;
  }
  return sum + (positionOf(last) - positionOf(begin)).norm();
}

bool TravelBound::allows(const PoseEdge& tie) const {
  const auto [a, b] = nearestInTime(keyframes_[tie.from].part, keyframes_[tie.to].part);
  if (a < 0) return true;
  const auto there = graph_.between(a, tie.from), back = graph_.between(tie.to, b);
  if (!there || !back) return true;
  const PoseWithCovariance T_a_b = *there * tie.T_from_to * *back;
  return T_a_b.T.translation().norm() <=
         farthest(std::min(a, b), std::max(a, b)) + kSigmas * largestTranslationStd(T_a_b.P);
}

}  // namespace facetloc::internal
