// SPDX-License-Identifier: BSD-3-Clause
#include "belief/place_following.h"

#include "poses/pose_fusion.h"

#include <facetloc/registration/pose_prior.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <vector>

namespace facetloc::internal {
namespace {

constexpr int kModels = 5;           // nearest local models that a view is aligned with
constexpr int kDenseIterations = 4;  // iterations of the alignment by all pixels
constexpr double kCorrelatedViews =
    2;  // number of views that count as one independent view: they see the same models with the same errors
constexpr double kFloorLength = 0.7;  // distance after which a robot on wheels stands on other unevenness [m]
constexpr double kLeastAgreement = 0.6;  // share of the depth pixels that the map must confirm
constexpr double kSureAgreement = 0.85;  // agreement of a place that is beyond doubt
constexpr double kKnownPixels = 0.1;     // share of them that must be in the map for it to object

// Pixels hidden from the other camera do not count.
double share(const DepthAgreement& a) {
  return a.agree + a.contradict > 0 ? a.agree / double(a.agree + a.contradict) : 0;
}

ViewAlignmentParams alignmentParams(const MatchingParams& matching) {
  ViewAlignmentParams params = alignmentWithCovariance(true, matching);
  params.dense.iterations = kDenseIterations;
  return params;
}

}  // namespace

void RepeatedObservations::discount(LocalMap& surroundings) const {
  constexpr double kMost = 0.9999;  // correlation: keeps covariances finite while the camera stands
  for (std::size_t i = 0; i < surroundings.segments.size(); ++i) {
    const LocalMap::Origin& origin = surroundings.origins[i];
    const auto found = correlation_.find({origin.view, origin.segment});
    if (found == correlation_.end()) continue;
    const double rho = std::min(found->second, kMost);
    surroundings.segments[i].Sigma_q *= (1 + rho) / (1 - rho);
  }
}

void RepeatedObservations::add(const std::vector<SegmentPair>& pairs, const LocalMap& surroundings) {
  for (const SegmentPair& p : pairs) {
    const LocalMap::Origin& origin = surroundings.origins[p.model];
    correlation_[{origin.view, origin.segment}] = 1;
  }
}

void RepeatedObservations::move(const Eigen::Isometry3d& T_a_b) {
  constexpr double kForgotten = 0.01;
  const double kept =
      std::exp(-T_a_b.translation().norm() / kDistance - rotationAngle(T_a_b.linear()) / kRotation);
  for (auto observation = correlation_.begin(); observation != correlation_.end();) {
    observation->second *= kept;
    observation = observation->second < kForgotten ? correlation_.erase(observation) : std::next(observation);
  }
}

bool FollowedPlace::isContradicted() const { return is_judged && agreement < kLeastAgreement; }
bool FollowedPlace::isInDoubt() const { return is_judged && agreement < kSureAgreement; }

PlaceFollowing::PlaceFollowing(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params)
    : surroundings_(std::move(map), DepthComparison(params.calibration.depth)),
      floor_covariance_(floorCovariance(params.prior)),
      alignment_(alignmentParams(params.matching)),
      comparison_(refinedErrors(params.calibration)) {}

PoseWithCovariance PlaceFollowing::onFloor(const View& view, int part, const PoseWithCovariance& T_w_c,
                                           const Eigen::Isometry3d& motion) const {
  constexpr int kFloorModels = 20;
  constexpr double kTurningWheel = 0.2;  // distance of a wheel by turning on the spot [m/rad]
  const Camera& camera = surroundings_.map().camera;
  if (!camera.mounting || !view.camera || !differenceOf(*view.camera, camera).sameMounting()) return T_w_c;
  const double distance = motion.translation().norm() + kTurningWheel * rotationAngle(motion.linear());
  if (!(distance > 0)) return T_w_c;
  const auto floor = surroundings_.floorNear(part, T_w_c.T, kFloorModels, floor_covariance_);
  if (!floor) return T_w_c;
  const double repeated = std::max(1.0, kFloorLength / distance);
  return updatedByFloor(T_w_c, *camera.mounting, *floor, floor_covariance_, repeated);
}

FollowedPlace PlaceFollowing::at(const View& view, int part, const PoseWithCovariance& T_w_c) const {
  FollowedPlace out;
  out.surroundings = surroundings_.around(view, part, T_w_c.T, kModels);
  observations_.discount(out.surroundings);
  out.alignment = alignView(view, out.surroundings, T_w_c, alignment_);
  out.alignment.T_w_c.P = temper(T_w_c.P, out.alignment.T_w_c.P, 1 / kCorrelatedViews);
  if (view.depth.empty()) return out;
  const DepthAgreement of_map =
      compareWithAll(view.depth, out.alignment.T_w_c.T, out.surroundings.pictures, comparison_, kFineColumns);
  out.agreement = share(of_map);
  const int grid = gridStep(view.depth, kFineColumns);
  const int pixels = (view.depth.camera.width / grid) * (view.depth.camera.height / grid);
  out.is_judged = of_map.agree + of_map.contradict >= kKnownPixels * pixels;
  return out;
}

std::optional<Hypothesis> PlaceFollowing::match(const FollowedPlace& place, int part) const {
  std::map<int, std::vector<SegmentPair>> of_model;
  for (const SegmentPair& p : place.alignment.pairs) {
    const LocalMap::Origin& origin = place.surroundings.origins[p.model];
    of_model[origin.view].push_back({p.scene, origin.segment, p.distance});
  }
  if (of_model.empty()) return {};
  // The first in the map is taken of several with as many pairs.
  const auto most = std::max_element(of_model.begin(), of_model.end(), [](const auto& a, const auto& b) {
    return a.second.size() < b.second.size();
  });
  Hypothesis match;
  match.model = most->first;
  match.part = part;
  match.pairs = most->second;
  match.T_m_c = surroundings_.map().models[match.model].T_w_m->inverse() * place.alignment.T_w_c;
  match.T_w_c = place.alignment.T_w_c.T;
  return match;
}

}  // namespace facetloc::internal
