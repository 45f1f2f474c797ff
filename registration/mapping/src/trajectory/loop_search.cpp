// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/loop_search.h"

#include "graph/consistency_graph.h"
#include "poses/pose_fusion.h"
#include "shortlist/plane_triplet_matcher.h"

#include <facetloc/localization/place_index.h>
#include <facetloc/registration/pose_prior.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace facetloc::internal {
namespace {

using Source = KeyframeMotion::Source;

constexpr int kNeighbours = 12;  // nearest earlier keyframes that one is compared with, a limit of time
constexpr double kReach = 1.5;  // between keyframes that are compared: farther, too few pixels are shared [m]
constexpr double kReachAngle = 45 * kDegree;  // between the viewing directions of keyframes that are compared
// Standard deviations of a relative pose, beyond which a lone loop is not believed [m, rad].
constexpr double kTrustedStd = 0.3, kTrustedRotation = 5 * kDegree;
constexpr int kConsistentLoops = 3;  // that must agree before an uncertain one of them is believed
constexpr double kUncertainStd = 1, kUncertainRotation = 10 * kDegree;  // beyond, several rooms may fit [m]
constexpr int kMostUncertain = 15;           // earlier keyframes that one is compared with far from certainty
constexpr int kLocal = 20;                   // keyframes in a row between which no loop is closed
constexpr double kSearchStd = 0.1;           // beyond which other places within a prior are searched [m]
constexpr double kSameLookOverlap = 0.5;     // share of the pixels of two keyframes that show the same thing
constexpr int kIndependentTies = 2;          // that must agree before two pieces become one
constexpr PoseRadius kSamePrior{0.02, 0.5};  // change of a prior after which a pair is compared anew

bool isTrusted(const Matrix6d& P) {
  return largestTranslationStd(P) <= kTrustedStd && largestRotationStd(P) <= kTrustedRotation;
}

PoseWithCovariance anywhere(const std::optional<CameraMounting>& mounting) {
  return {Eigen::Isometry3d::Identity(), posePrior(mounting)};
}

// True for keyframes of one part that are as far apart as a new keyframe is from the last.
NodesApart keyframesApart(const TrajectoryGraph& graph, const ViewOdometryParams& params) {
  const PoseRadius radius{params.key_distance, params.key_rotation_deg};
  return [&graph, radius](int a, int b) { return !radius.joins(graph[a].T_w_c.T, graph[b].T_w_c.T); };
}

// True for keyframes of one part with little in common. The answers are kept for the poses of now.
NodesApart viewsApart(const TrajectoryGraph& graph) {
  const auto known = std::make_shared<std::map<std::pair<int, int>, bool>>();
  return [&graph, known](int a, int b) {
    if (a == b) return false;
    const auto [answer, is_new] = known->try_emplace(std::minmax(a, b));
    if (is_new)
      answer->second = overlapOf(graph.between(a, b), *graph[a].view, *graph[b].view) < kSameLookOverlap;
    return answer->second;
  };
}

// The loops that enough others confirm.
std::vector<KeyframeMotion> confirmed(const std::vector<PoseEdge>& loops, const GraphCovariance& known,
                                      int least, const NodesApart& apart) {
  const std::vector<bool> is_confirmed = consistentLoops(loops, known, least, apart);
  std::vector<KeyframeMotion> out;
  for (std::size_t i = 0; i < loops.size(); ++i)
    if (is_confirmed[i]) out.push_back({loops[i].from, loops[i].to, loops[i].T_from_to, Source::loop});
  return out;
}

// Independent ties between pieces; none where they leave the relative pose of the pieces loose.
PieceBonds bondsOf(const TrajectoryGraph& graph, int threads) {
  std::map<PiecePair, std::vector<std::pair<int, int>>> between;
  for (const KeyframeMotion& m : graph.relations()) {
    const PiecePair pieces = graph.piecesOf(m.from, m.to);
    if (pieces.first == pieces.second) continue;
    const bool forward = graph[m.from].piece == pieces.first;
    between[pieces].emplace_back(forward ? m.from : m.to, forward ? m.to : m.from);
  }
  PieceBonds out;
  if (between.empty()) return out;
  const GraphCovariance known(graph.poseGraph(), threads);
  const auto isTight = [&](const std::pair<int, int>& tie) {
    const auto T = known.between(tie.first, tie.second);
    return T && isTrusted(T->P);
  };
  const NodesApart apart = viewsApart(graph);
  for (const auto& [pieces, found] : between)
    out[pieces] = std::any_of(found.begin(), found.end(), isTight) ? independentTies(found, apart) : 0;
  return out;
}

constexpr int kMostSimilar = 15;    // earlier keyframes that one is compared with for their likeness
constexpr int kClose = 10;          // numbers of keyframes that are compared whatever they show
constexpr int kIndexed = 100;       // earlier keyframes by the index whose planes are overlaid
constexpr int kIndexAligned = 300;  // those that the index aligns with a view

/** An index of keyframes by their planes. */
PlaceIndex indexOf(const std::vector<TrajectoryNode>& keyframes, const CameraMounting& mounting) {
  Map map;
  map.camera.mounting = mounting;
  for (const TrajectoryNode& k : keyframes) map.models.emplace_back().setView(k.view);
  ShortlistParams params;
  params.aligned_models = kIndexAligned;
  return PlaceIndex(map, params);
}

/** The earlier keyframes of other parts whose planes are overlaid with a keyframe's, in their order: all, or
 * the most similar ones by an index. */
std::vector<int> earlierKeyframes(const std::vector<TrajectoryNode>& keyframes, int b,
                                  const std::optional<PlaceIndex>& index) {
  const auto isExcluded = [&](int a) { return a >= b || keyframes[a].part == keyframes[b].part; };
  std::vector<int> earlier;
  if (index) {
    for (const ShortlistedModel& found : index->candidates(*keyframes[b].view, kIndexed, isExcluded))
      earlier.push_back(found.model);
    std::sort(earlier.begin(), earlier.end());
    return earlier;
  }
  for (int a = 0; a < b; ++a)
    if (!isExcluded(a)) earlier.push_back(a);
  return earlier;
}

std::vector<int> mostSimilar(const std::vector<TrajectoryNode>& keyframes,
                             const std::vector<PlaneColumns>& planes, const std::optional<PlaceIndex>& index,
                             int b, const PoseWithCovariance& prior) {
  const PlaneTripletMatcher overlay(*keyframes[b].view, prior);
  if (!overlay.isUseful()) return {};
  std::vector<std::pair<float, int>> similar;
  for (const int a : earlierKeyframes(keyframes, b, index)) {
    const Overlay laid = overlay.on(planes[a]);
    if (laid.exists()) similar.emplace_back(-laid.score, a);
  }
  std::sort(similar.begin(), similar.end());
  std::vector<int> best;
  for (std::size_t i = 0; i < std::min<std::size_t>(kMostSimilar, similar.size()); ++i)
    best.push_back(similar[i].second);
  return best;
}

/** Bound on ties by the distance that the camera may have covered between two parts. */
class TravelBound {
public:
  TravelBound(const TrajectoryGraph& graph, const CameraSpeed& speed, const GraphCovariance& known)
      : keyframes_(graph.nodes()), speed_(speed), known_(known) {}

  /** False if the camera would have had to move much faster than it does. Anything is possible across an
   * interruption. */
  bool allows(const PoseEdge& tie) const {
    constexpr double kSigmas = 3;
    const auto [a, b] = nearestInTime(keyframes_[tie.from].part, keyframes_[tie.to].part);
    if (a < 0) return true;
    const auto there = known_.between(a, tie.from), back = known_.between(tie.to, b);
    if (!there || !back) return true;
    const PoseWithCovariance T_a_b = *there * tie.T_from_to * *back;
    return T_a_b.T.translation().norm() <=
           farthest(std::min(a, b), std::max(a, b)) + kSigmas * largestTranslationStd(T_a_b.P);
  }

private:
  /** Keyframes of the two parts, nearest in time; (-1, -1) if the camera was interrupted between all of
   * them. */
  std::pair<int, int> nearestInTime(int part_a, int part_b) const {
    std::pair<int, int> nearest{-1, -1};
    double least = 0;
    int latest_a = -1, latest_b = -1;
    for (int k = 0; k < static_cast<int>(keyframes_.size()); ++k) {
      if (keyframes_[k].part == part_a) latest_a = k;
      if (keyframes_[k].part == part_b) latest_b = k;
      const bool is_of_either = k == latest_a || k == latest_b;
      if (!is_of_either || latest_a < 0 || latest_b < 0 ||
          keyframes_[latest_a].run != keyframes_[latest_b].run)
        continue;
      const double duration = std::abs(keyframes_[latest_a].stamp - keyframes_[latest_b].stamp);
      if (nearest.first >= 0 && duration >= least) continue;
      nearest = {latest_a, latest_b};
      least = duration;
    }
    return nearest;
  }

  /** Largest distance of the camera's motion between two keyframes: the known displacements of the parts in
   * between, and the distance that its speed allows from one to the next. */
  double farthest(int first, int last) const {
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

  const std::vector<TrajectoryNode>& keyframes_;
  const CameraSpeed& speed_;
  const GraphCovariance& known_;
};

}  // namespace

std::vector<std::pair<int, int>> tieCandidates(const std::vector<TrajectoryNode>& keyframes, int first,
                                               const std::optional<CameraMounting>& mounting,
                                               const ChunkedWork& work, long long exhaustive_up_to) {
  const int n = static_cast<int>(keyframes.size());
  const int part = keyframes.empty() ? 0 : keyframes.front().part;
  if (std::all_of(keyframes.begin(), keyframes.end(),
                  [part](const TrajectoryNode& k) { return k.part == part; }))
    return {};
  if (work.progress) work.progress(0);
  std::vector<PlaneColumns> planes;
  for (const TrajectoryNode& k : keyframes) planes.emplace_back(*k.view);
  std::optional<PlaceIndex> index;
  if (mounting && static_cast<long long>(n - first) * (n + first) / 2 > exhaustive_up_to)
    index = indexOf(keyframes, *mounting);
  const PoseWithCovariance prior = anywhere({});
  std::vector<std::vector<int>> partners(n - first);
  const auto findPartners = [&](int i) {
    std::vector<int>& of_b = partners[i];
    const int b = first + i;
    of_b = mostSimilar(keyframes, planes, index, b, prior);
    for (int a = std::max(0, b - kClose); a < b; ++a)
      if (keyframes[a].part != keyframes[b].part) of_b.push_back(a);
    std::sort(of_b.begin(), of_b.end());
    of_b.erase(std::unique(of_b.begin(), of_b.end()), of_b.end());
  };
  work.forEach(n - first, findPartners);
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < n - first; ++i)
    for (const int a : partners[i]) pairs.emplace_back(a, first + i);
  return pairs;
}

/** An earlier keyframe that one is compared with. */
struct LoopSearch::Pair {
  int a;
  PoseWithCovariance T_a_b;
  bool certain;
  std::optional<PlacedView> placed;
};

// The nearest earlier keyframes, and those that may be as near by an uncertain trajectory.
std::vector<LoopSearch::Pair> LoopSearch::pairsOf(int b, const GraphCovariance& known) const {
  const ViewReach reach{kReach, kReachAngle};
  const auto T_b = known.relativeTo(b);
  std::vector<std::pair<double, Pair>> certain, uncertain;
  for (int a = 0; a < b; ++a) {
    if (!T_b[a]) continue;
    const PoseWithCovariance T = inverse(*T_b[a]);
    const double std = largestTranslationStd(T.P);
    if (isTrusted(T.P)) {
      const double distance = viewDistance(Eigen::Isometry3d::Identity(), T.T, reach);
      if (std::isfinite(distance)) certain.push_back({distance, {a, T, true, {}}});
    } else if (b - a > kLocal && std <= kUncertainStd && largestRotationStd(T.P) <= kUncertainRotation) {
      const double beyond = std::max(0.0, T.T.translation().norm() - kReach) / std;
      if (beyond < 3) uncertain.push_back({beyond, {a, T, false, {}}});
    }
  }
  std::vector<Pair> out;
  const auto takeNearest = [&out](std::vector<std::pair<double, Pair>>& pairs, int most) {
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const auto& x, const auto& y) { return x.first < y.first; });
    for (int i = 0; i < std::min<int>(most, pairs.size()); ++i) out.push_back(std::move(pairs[i].second));
  };
  takeNearest(certain, kNeighbours);
  takeNearest(uncertain, kMostUncertain);
  return out;
}

void LoopSearch::compare(int b, const Comparisons& compared, const TrajectoryGraph& graph, Pair& pair) const {
  const auto before = compared.find({pair.a, b});
  if (before != compared.end() && kSamePrior.joins(before->second.prior, pair.T_a_b.T))
    pair.placed = before->second.placed;
  else
    pair.placed = registered(placing_, *graph[b].view, *graph[pair.a].view,
                             pair.certain ? pair.T_a_b : anywhere(graph.mounting()),
                             !pair.certain || largestTranslationStd(pair.T_a_b.P) > kSearchStd);
}

std::vector<KeyframeMotion> LoopSearch::withinParts(const TrajectoryGraph& graph,
                                                    const GraphCovariance& known, int first,
                                                    const ChunkedWork& work) {
  const int n = graph.size();
  const auto compared = std::make_shared<Comparisons>(*compared_);
  for (int b = 0; b < n; ++b)
    if (graph[b].at.placed)
      compared->try_emplace({graph[b].before, b}, Comparison{graph[b].at.T, false, graph[b].at.placed});
  std::vector<std::vector<Pair>> pairs(n);
  work.forEach(n - first, [&](int i) {
    pairs[first + i] = pairsOf(first + i, known);
    for (Pair& pair : pairs[first + i]) compare(first + i, *compared, graph, pair);
  });

  std::vector<KeyframeMotion> out;
  std::vector<PoseEdge> uncertain;
  for (int b = first; b < n; ++b)
    for (const Pair& p : pairs[b]) {
      (*compared)[{p.a, b}] = {p.T_a_b.T, !p.certain, p.placed};
      if (!p.placed) continue;
      const PoseWithCovariance T = measured(*p.placed);
      if (squaredMahalanobis(p.T_a_b, T) > kFarEllipsoid) continue;
      if (p.certain)
        out.push_back({p.a, b, T, b - p.a > kLocal ? Source::loop : Source::overlap});
      else if (isClear(*p.placed))
        uncertain.push_back({p.a, b, T, true});
    }
  compared_ = compared;
  const std::vector<KeyframeMotion> loops =
      confirmed(uncertain, known, kConsistentLoops, keyframesApart(graph, params_.odometry));
  out.insert(out.end(), loops.begin(), loops.end());
  return out;
}

// Compares keyframes of different parts, each pair once.
void LoopSearch::compareTies(const std::vector<std::pair<int, int>>& pairs, const TrajectoryGraph& graph,
                             const ChunkedWork& work) {
  std::vector<std::pair<int, int>> missing;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(missing),
               [&](const std::pair<int, int>& pair) { return ties_.count(pair) == 0; });
  const PoseWithCovariance prior = anywhere(graph.mounting());
  std::vector<std::optional<PlacedView>> placed(missing.size());
  work.forEach(static_cast<int>(missing.size()), [&](int i) {
    placed[i] =
        registered(placing_, *graph[missing[i].second].view, *graph[missing[i].first].view, prior, true);
  });
  for (std::size_t i = 0; i < missing.size(); ++i) ties_[missing[i]] = placed[i];
}

std::vector<KeyframeMotion> LoopSearch::betweenParts(const TrajectoryGraph& graph,
                                                     const GraphCovariance& known, int first,
                                                     const CameraSpeed& speed, const ChunkedWork& work) {
  const std::vector<std::pair<int, int>> pairs =
      tieCandidates(graph.nodes(), first, graph.mounting(), work.section(0, 0.5));
  compareTies(pairs, graph, work.section(0.5, 1));
  const TravelBound bound(graph, speed, known);
  std::vector<PoseEdge> found;
  for (const auto& pair : pairs) {
    const auto& placed = ties_.at(pair);
    if (!placed || !isClear(*placed)) continue;
    const PoseEdge tie{pair.first, pair.second, measured(*placed), true};
    if (bound.allows(tie)) found.push_back(tie);
  }
  return confirmed(found, known, kIndependentTies, viewsApart(graph));
}

PieceVerdicts LoopSearch::verdicts(const TrajectoryGraph& graph, int threads) const {
  std::vector<const Comparisons::value_type*> compared;
  for (const auto& pair_compared : *compared_)
    if (const auto& [a, b] = pair_compared.first; graph[a].part == graph[b].part)
      compared.push_back(&pair_compared);
  std::vector<std::optional<bool>> confirmed(compared.size());
  forEachInParallel(static_cast<int>(compared.size()), threads, [&](int i) {
    const auto& [a, b] = compared[i]->first;
    confirmed[i] = isConfirmed(graph.between(a, b), *graph[a].view, *graph[b].view, compared[i]->second);
  });
  PieceVerdicts out;
  for (std::size_t i = 0; i < compared.size(); ++i) {
    OverlapVerdicts& of_pieces = out[graph.piecesOf(compared[i]->first.first, compared[i]->first.second)];
    of_pieces.confirmed += confirmed[i] == true;
    of_pieces.contradicted += confirmed[i] == false;
  }
  return out;
}

bool LoopSearch::cutContradicted(TrajectoryGraph& graph, int threads) {
  for (bool is_cut = false;; is_cut = true) {
    const auto bond = weakestBond(verdicts(graph, threads), bondsOf(graph, threads), kIndependentTies);
    if (!bond) return is_cut;
    std::vector<KeyframeMotion> left;
    for (const KeyframeMotion& m : graph.relations())
      if (graph.piecesOf(m.from, m.to) != *bond)
        left.push_back(m);
      else if (const auto tie = ties_.find({m.from, m.to}); tie != ties_.end())
        tie->second.reset();
    ++cut_bonds_;
    graph.optimize(std::move(left));
  }
}

}  // namespace facetloc::internal
