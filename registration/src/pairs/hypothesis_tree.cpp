// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/hypothesis_tree.h"

#include "pairs/cholesky3.h"
#include "pairs/plane_measurement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <queue>

namespace facetloc::internal {
namespace {

// Relation of two segments of one image, whatever the pose of the camera.
struct Relation {
  double angle = 0;      // between the normals [rad]
  double angle_var = 0;  // its variance
  double gap = 0;  // distance between the plane of the one and the centroid of the other, for nearly parallel
                   // planes [m]
  double gap_var = 0;
};

// Up to this angle the distance between two planes is a property of the pair, with the tilt as its error.
constexpr double kNearlyParallel = 5 * kDegree;

class Relations {
public:
  explicit Relations(const std::vector<Segment>& s, int n) : n_(n), table_(static_cast<std::size_t>(n) * n) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        if (i == j) continue;
        Relation& r = table_[static_cast<std::size_t>(i) * n + j];
        const Eigen::Vector3d a = s[i].normal(), b = s[j].normal(), d = s[j].t - s[i].t;
        r.angle = std::atan2(a.cross(b).norm(), a.dot(b));
        r.angle_var = slopeVariance(s[i]) + slopeVariance(s[j]);
        r.gap = a.dot(d);
        r.gap_var = s[i].Sigma_q(2, 2) + s[j].Sigma_q(2, 2) +
                    (slopeVariance(s[i]) + slopeVariance(s[j]) + r.angle * r.angle) * d.squaredNorm();
      }
  }
  const Relation& at(int i, int j) const { return table_[static_cast<std::size_t>(i) * n_ + j]; }

private:
  static double slopeVariance(const Segment& s) { return s.Sigma_q(0, 0) + s.Sigma_q(1, 1); }

  int n_;
  std::vector<Relation> table_;
};

bool consistent(const Relation& scene, const Relation& model, double gate) {
  const double angle = scene.angle - model.angle;
  if (angle * angle > gate * gate * (scene.angle_var + model.angle_var)) return false;
  if (scene.angle > kNearlyParallel || model.angle > kNearlyParallel) return true;
  const double gap = scene.gap - model.gap;
  return gap * gap <= gate * gate * (scene.gap_var + model.gap_var);
}

// A set of candidate pairs, one bit each.
using PairSet = std::vector<std::uint64_t>;

int firstAfter(const PairSet& set, int i) {
  for (std::size_t word = static_cast<std::size_t>(++i) / 64; word < set.size();
       ++word, i = static_cast<int>(word * 64)) {
    const std::uint64_t rest = set[word] >> (i % 64);
    if (rest) return i + __builtin_ctzll(rest);
  }
  return -1;
}

struct Node {
  int parent;
  int last;   // index of its last candidate pair
  int depth;  // number of pairs
  PoseWithCovariance pose;
  Matrix6d information;
  PairSet allowed;  // pairs that may follow
};

/** A search in progress. */
struct Search {
  const std::vector<Segment>& scene;
  const std::vector<Segment>& model;
  const std::vector<SegmentPair>& candidates;
  const MatchingParams& matching;
  const EkfParams& ekf;
  const HypothesisTreeParams& params;
  const Matrix6d& known;
  const bool extents;
  std::size_t words = 0;
  std::vector<PairSet> compatible{};  // for each pair the later ones that are compatible with it
  std::vector<Node> nodes{};
  std::priority_queue<std::pair<int, int>>
      queue{};  // (-last pair, -node): best-ranked last pair first, oldest first
  TreeSearchResult result{};

  TreeSearchResult run(const PoseWithCovariance& prior) {
    findCompatible();
    nodes.push_back({-1, -1, 0, prior, Matrix6d::Zero(), PairSet(words, ~std::uint64_t{0})});
    for (std::size_t bit = candidates.size(); bit < words * 64; ++bit)
      nodes[0].allowed[bit / 64] &= ~(std::uint64_t{1} << (bit % 64));
    pushNext(0, -1);
    while (!queue.empty() && result.expansions < params.max_expansions &&
           static_cast<int>(result.by_pairs.complete.size()) < params.max_hypotheses) {
      const int id = -queue.top().second;
      queue.pop();
      pushNext(nodes[id].parent, nodes[id].last);  // the next sibling, made lazily
      expand(id);
    }
    return std::move(result);
  }

  void findCompatible() {
    const int m = static_cast<int>(candidates.size());
    words = (m + 63) / 64;
    compatible.assign(m, PairSet(words, 0));
    int n_scene = 0, n_model = 0;
    for (const SegmentPair& c : candidates) {
      n_scene = std::max(n_scene, c.scene + 1);
      n_model = std::max(n_model, c.model + 1);
    }
    const Relations of_scene(scene, n_scene), of_model(model, n_model);
    for (int a = 0; a < m; ++a)
      for (int b = a + 1; b < m; ++b) {
        const SegmentPair &p = candidates[a], &q = candidates[b];
        if (p.scene == q.scene || p.model == q.model) continue;
        if (consistent(of_scene.at(p.scene, q.scene), of_model.at(p.model, q.model), params.angle_gate))
          compatible[a][b / 64] |= std::uint64_t{1} << (b % 64);
      }
  }

  // Queues the first pair after the given one that may follow the parent's. Cheap tests come first: most
  // pairs fail.
  void pushNext(int parent, int after) {
    const Node& p = nodes[parent];
    int pair = firstAfter(p.allowed, after);
    while (pair >= 0 && p.depth > 0 && !plausible(candidates[pair], p.pose))
      pair = firstAfter(p.allowed, pair);
    if (pair < 0) return;
    nodes.push_back({parent, pair, p.depth + 1, {}, Matrix6d::Zero(), {}});
    queue.push({-pair, -(static_cast<int>(nodes.size()) - 1)});
  }

  bool plausible(const SegmentPair& pair, const PoseWithCovariance& pose) const {
    constexpr double kHopeless = 40;  // before the update: no iteration saves such a pair (METHOD 6.1)
    const Segment &F = scene[pair.scene], &Fp = model[pair.model];
    return offsetDistance(F, Fp, pose) <= kHopeless &&
           overlapDistance(F, Fp, pose, matching.overlap_gate) <= matching.overlap_gate;
  }

  void expand(int id) {
    const SegmentPair& pair = candidates[nodes[id].last];
    const Segment &F = scene[pair.scene], &Fp = model[pair.model];
    const Node& parent = nodes[nodes[id].parent];
    ++result.expansions;
    const EkfUpdate update = ekfPoseUpdate(F, Fp, parent.pose, ekf);
    if (!update.accepted || update.gain < params.min_gain) return;
    Node& node = nodes[id];
    node.pose = update.pose;
    node.information = parent.information + update.information;
    node.allowed.resize(words);
    for (std::size_t w = 0; w < words; ++w) node.allowed[w] = parent.allowed[w] & compatible[node.last][w];

    if (keep(node)) return;
    if (node.depth < params.max_pairs) pushNext(id, node.last);
  }

  // True if pairs alone make the pose complete.
  bool keep(const Node& node) {
    const double max_rotation = params.complete_rotation_deg * kDegree;
    const auto isComplete = [&](const PrincipalStd& o) {
      return o.within(max_rotation, params.complete_translation);
    };
    const auto leavesOneFree = [&](const PrincipalStd& o) {
      return o.oneTranslationFree(max_rotation, params.complete_translation);
    };
    const Eigen::Vector3d none_free = Eigen::Vector3d::Zero();
    const PrincipalStd alone = observability(node.information);
    if (isComplete(alone)) {
      emit(node, none_free, result.by_pairs.complete);
      return true;
    }
    const bool one_free = leavesOneFree(alone);
    if (one_free) emit(node, alone.translation_axes.col(2), result.by_pairs.incomplete);
    if (extents) keepByExtents(node, isComplete);
    std::vector<PoseNode>& with_known = result.with_known.complete;
    if (known.isZero() || static_cast<int>(with_known.size()) >= params.max_hypotheses) return false;
    const PrincipalStd together = observability(node.information + known);
    if (isComplete(together))
      emit(node, none_free, with_known);
    else if (!one_free && leavesOneFree(together))
      emit(node, together.translation_axes.col(2), result.with_known.incomplete);
    return false;
  }

  // Pairs have agreed that their segments overlap, which says where the camera is along their planes.
  template <class IsComplete>
  void keepByExtents(const Node& node, const IsComplete& isComplete) {
    if (static_cast<int>(result.by_extents.size()) >= params.max_hypotheses) return;
    Matrix6d information = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    for (const Node* n = &node; n->parent >= 0; n = &nodes[n->parent]) {
      const SegmentPair& pair = candidates[n->last];
      const ExtentMeasurement m = measureExtent(scene[pair.scene], model[pair.model], node.pose.T);
      information += informationOf(m);
      gradient += m.H.transpose() * m.W.ldlt().solve(m.h);
    }
    if (!gradient.allFinite() || !isComplete(observability(node.information + known + information))) return;
    Node moved = node;
    moved.pose.P = symmetricInverse(symmetricInverse(node.pose.P) + information);
    moved.pose.T = boxplus(node.pose.T, -moved.pose.P * gradient);
    emit(moved, Eigen::Vector3d::Zero(), result.by_extents);
  }

  // Keeps a pose unless it was found before; of incomplete poses the position along the free direction does
  // not count.
  void emit(const Node& node, const Eigen::Vector3d& free_direction, std::vector<PoseNode>& found) {
    const double same_direction = std::cos(10 * kDegree);  // METHOD 6.5
    const bool incomplete = !free_direction.isZero();
    const double factor = incomplete ? 2 : 1;  // METHOD 6.5: (1 deg, 0.05 m) and (2 deg, 0.1 m)
    for (const PoseNode& other : found) {
      if (incomplete && std::abs(other.free_direction.dot(free_direction)) < same_direction) continue;
      Eigen::Vector3d shift = node.pose.T.translation() - other.pose.T.translation();
      if (incomplete) shift -= free_direction * free_direction.dot(shift);
      if (shift.norm() > factor * params.duplicate_translation) continue;
      const double turn = rotationAngle(node.pose.T.linear() * other.pose.T.linear().transpose());
      if (turn <= factor * params.duplicate_rotation_deg * kDegree) return;
    }
    PoseNode out;
    out.pose = node.pose;
    out.information = node.information;
    out.free_direction = free_direction;
    for (const Node* n = &node; n->parent >= 0; n = &nodes[n->parent])
      out.pairs.push_back(candidates[n->last]);
    std::reverse(out.pairs.begin(), out.pairs.end());
    found.push_back(std::move(out));
  }
};

}  // namespace

TreeSearchResult searchHypotheses(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                                  const std::vector<SegmentPair>& candidates, const PoseWithCovariance& prior,
                                  const MatchingParams& matching, const EkfParams& ekf,
                                  const HypothesisTreeParams& params, const Matrix6d& known, bool extents) {
  if (candidates.empty()) return {};
  return Search{scene, model, candidates, matching, ekf, params, known, extents}.run(prior);
}

}  // namespace facetloc::internal
