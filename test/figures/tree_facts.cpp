// SPDX-License-Identifier: BSD-3-Clause
#include "facts.h"
#include "pairs/ekf_pose_update.h"
#include "pairs/hypothesis_tree.h"
#include "pairs/plane_measurement.h"

#include <facetloc/registration/candidate_pairs.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/synthetic_views.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

namespace facetloc::figures {
namespace {

using namespace internal;
using Pairs = std::vector<SegmentPair>;

std::set<std::pair<int, int>> setOf(const Pairs& pairs) {
  std::set<std::pair<int, int>> out;
  for (const SegmentPair& pair : pairs) out.emplace(pair.scene, pair.model);
  return out;
}

/** A corner of a room: floor, a wall on the left and one ahead; and a cupboard before that, if it is there.
 */
test::Scene corner(bool with_cupboard) {
  test::Scene room = test::box({0, 0, 0}, {8, 8, 4});
  return with_cupboard ? room + test::box({1.35, 7.5, 0}, {2.6, 8, 2.4}) : room;
}

/** Walks all sets of candidates, whose updates the search would also make. */
class Walk {
public:
  Walk(const View& scene, const View& model, Pairs candidates, const TreeSearchResult& found)
      : scene_(scene), model_(model), candidates_(std::move(candidates)) {
    for (const PoseNode& node : found.by_pairs.complete) complete_.insert(setOf(node.pairs));
  }

  Json::Value below(const PoseWithCovariance& pose, const Pairs& pairs, std::size_t first) const {
    Json::Value children(Json::arrayValue);
    for (std::size_t i = first; i < candidates_.size(); ++i) {
      const SegmentPair& next = candidates_[i];
      const bool used = std::any_of(pairs.begin(), pairs.end(), [&](const SegmentPair& pair) {
        return pair.scene == next.scene || pair.model == next.model;
      });
      if (used) continue;
      children.append(node(pose, pairs, i));
    }
    return children;
  }

private:
  Json::Value node(const PoseWithCovariance& pose, Pairs pairs, std::size_t i) const {
    const SegmentPair& pair = candidates_[i];
    const Segment &F = scene_.segments[pair.scene], &model = model_.segments[pair.model];
    const EkfUpdate update = ekfPoseUpdate(F, model, pose);
    const double overlap = overlapDistance(F, model, pose);
    const bool accepted = update.accepted && (pairs.empty() || overlap <= MatchingParams{}.overlap_gate);
    pairs.push_back(pair);
    const PrincipalStd known = principalStd(update.pose.P);
    Json::Value out;
    out["scene"] = pair.scene, out["model"] = pair.model;
    out["accepted"] = accepted, out["overlap"] = rounded(overlap, 1);
    out["cost"] = rounded(update.cost, 2), out["gain"] = rounded(update.gain, 2);
    out["rotation_deg"] = rounded(known.rotation[2] * 180 / M_PI, 2),
    out["translation"] = rounded(known.translation[2], 3);
    out["complete"] = complete_.count(setOf(pairs)) > 0;
    const bool goes_on = accepted && !out["complete"].asBool();
    out["children"] = goes_on ? below(update.pose, pairs, i + 1) : Json::Value(Json::arrayValue);
    return out;
  }

  const View &scene_, &model_;
  Pairs candidates_;
  std::set<std::set<std::pair<int, int>>> complete_;
};

Json::Value names(const View& view, const Eigen::Isometry3d& T_w_c) {
  Json::Value out(Json::arrayValue);
  for (const Segment& segment : view.segments) {
    Json::Value one;
    one["normal"] = numbers(Eigen::Vector3d(T_w_c.linear() * segment.normal()), 2);
    one["centroid"] = numbers(Eigen::Vector3d(T_w_c * segment.t), 2);
    out.append(one);
  }
  return out;
}

}  // namespace

Json::Value treeFacts() {
  const Eigen::Isometry3d T_w_m = test::lookingAlong({2.3, 5.3, 1.5}, {-0.45, 1, -0.35}),
                          T_w_c = test::lookingAlong({2.5, 5.0, 1.5}, {-0.62, 1, -0.38});
  const View model = test::viewFrom(corner(true), T_w_m, 1), scene = test::viewFrom(corner(false), T_w_c, 2);
  const PoseWithCovariance prior{Eigen::Isometry3d::Identity(), posePrior({})};
  const Pairs candidates = candidatePairs(scene.segments, model.segments, prior);
  const TreeSearchResult found =
      searchHypotheses(scene.segments, model.segments, candidates, prior, {}, {}, {});
  Json::Value out;
  out["scene"] = names(scene, T_w_c), out["model"] = names(model, T_w_m);
  out["scene_outlines"] = outlines(scene), out["model_outlines"] = outlines(model);
  out["updates"] = found.expansions;
  for (const PoseNode& node : found.by_pairs.complete) {
    Json::Value one;
    for (const SegmentPair& pair : node.pairs) {
      Json::Value both;
      both.append(pair.scene), both.append(pair.model);
      one["pairs"].append(both);
    }
    const Eigen::Isometry3d wrong = T_w_c.inverse() * T_w_m * node.pose.T;
    one["off"] = rounded(wrong.translation().norm(), 3);
    out["found"].append(one);
  }
  out["root"]["rotation_deg"] = 20, out["root"]["translation"] = 1;
  out["root"]["children"] = Walk(scene, model, candidates, found).below(prior, {}, 0);
  return out;
}

}  // namespace facetloc::figures
