// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/direction_text.h"

#include <facetloc/registration/pose_prior.h>
#include <facetloc/registration/pose_tracking.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <map>

namespace facetloc {
namespace {

constexpr const char* kUnconfirmed = "a likely place waits for the next view to confirm it";

// Standard deviations along the principal axes of a block, ascending, and the axes.
struct PrincipalAxes {
  Eigen::Vector3d std;
  Eigen::Matrix3d axes;

  explicit PrincipalAxes(const Eigen::Matrix3d& block) {
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eig;
    eig.computeDirect(block);
    std = eig.eigenvalues().cwiseMax(0).cwiseSqrt();
    axes = eig.eigenvectors();
  }
};
PrincipalAxes rotationAxes(const Matrix6d& P) { return PrincipalAxes(P.topLeftCorner<3, 3>()); }
PrincipalAxes translationAxes(const Matrix6d& P) { return PrincipalAxes(P.bottomRightCorner<3, 3>()); }

bool exceeds(const Matrix6d& P, double rotation_deg, double translation) {
  return !(rotationAxes(P).std[2] <= rotation_deg * kDegree && translationAxes(P).std[2] <= translation);
}

// The motions that are less certain than that, in words and camera axes.
std::string freeDirections(const PoseWithCovariance& pose, double rotation_deg, double translation) {
  const Eigen::Matrix3d R_c_w = pose.T.linear().transpose();
  std::string text;
  const auto add = [&](const char* motion, const Eigen::Vector3d& v) {
    text += (text.empty() ? "" : ", ") + std::string(motion) + directionText(R_c_w * v);
  };
  const PrincipalAxes turns = rotationAxes(pose.P), shifts = translationAxes(pose.P);
  for (int i = 0; i < 3; ++i)
    if (!(turns.std[i] <= rotation_deg * kDegree)) add("rotation about ", turns.axes.col(i));
  for (int i = 0; i < 3; ++i)
    if (!(shifts.std[i] <= translation)) add("translation along ", shifts.axes.col(i));
  return text;
}

// What is hidden from the other camera says nothing.
double share(const DepthAgreement& a) {
  return a.agree + a.contradict > 0 ? a.agree / double(a.agree + a.contradict) : 0;
}

// A pose after a motion: its rotation error turns the way.
PoseWithCovariance moved(const PoseWithCovariance& T_w_a, const PoseWithCovariance& T_a_b) {
  const Eigen::Matrix3d R = T_w_a.T.linear();
  Matrix6d F = Matrix6d::Identity();
  F.bottomLeftCorner<3, 3>() = -skew(R * T_a_b.T.translation());
  return {T_w_a.T * T_a_b.T, F * T_w_a.P * F.transpose() + turned(R, T_a_b.P)};
}

// The covariance of a posterior if what was added to the prior told only a part of what it says.
Matrix6d discounted(const Matrix6d& prior, const Matrix6d& posterior, double part) {
  const Matrix6d before = prior.ldlt().solve(Matrix6d::Identity());
  const Matrix6d after = posterior.ldlt().solve(Matrix6d::Identity());
  const Matrix6d P = Matrix6d(before + part * (after - before)).ldlt().solve(Matrix6d::Identity());
  return 0.5 * (P + P.transpose());
}

ViewAlignmentParams alignmentParams(const GlobalLocalizationParams& localization,
                                    const PoseTrackingParams& tracking) {
  ViewAlignmentParams params;
  params.matching = localization.registration.matching;
  params.dense = localization.ranking.dense;
  params.dense.correlated_pixels = tracking.correlated_pixels;
  params.dense.significance = tracking.significance;
  params.dense.iterations = tracking.dense_iterations;
  return params;
}

}  // namespace

const char* stateName(TrackingState state) {
  switch (state) {
  case TrackingState::searching:
    return "searching";
  case TrackingState::localized:
    return "localized";
  case TrackingState::tracking:
    return "tracking";
  case TrackingState::cannot_tell:
    return "cannot tell";
  case TrackingState::lost:
    return "lost";
  }
  return "";
}

struct PoseTracking::Step {
  ViewAlignment alignment;
  Surroundings surroundings;
  DepthAgreement of_map;
  double view_agreement = 0;

  bool is_judged = false;  // the map knows enough of them
};

PoseTracking::PoseTracking(std::shared_ptr<const Map> map, const PoseTrackingParams& params,
                           const GlobalLocalizationParams& localization, const SensorNoise& noise)
    : params_(checked(params)),
      localization_(map, localization, noise),
      surroundings_(map, DepthComparison(localization.registration.depth, noise.inverse_depth_std)),
      floor_covariance_(floorCovariance(localization.prior)),
      alignment_(alignmentParams(localization, params)),
      comparison_(refinedErrors(localization.registration.depth, localization.ranking),
                  noise.inverse_depth_std),
      inverse_depth_std_(noise.inverse_depth_std),
      odometry_(params.odometry, alignment_, comparison_, noise.inverse_depth_std,
                surroundings_.map().mounting) {}

void PoseTracking::relocalize() {
  active_ = confirmed_ = ever_ = false;
  candidates_.clear();
}

TrackedPose PoseTracking::update(const View& view, double stamp) {
  const double dt = stamp - stamp_;
  stamp_ = stamp;
  if (!surroundings_.anyPose()) {
    TrackedPose out;
    out.reason = "no local model of the map has a pose in the world";
    return out;
  }
  const bool in_time = dt >= 0 && dt <= params_.max_gap;
  if (!in_time) odometry_.reset();
  if (dt < 0) next_check_ = stamp;
  ViewMotion motion = odometry_.add(view, in_time ? dt : 0);
  motion.broken = motion.broken || !in_time;
  if (!active_) return search(view, motion);
  if (!(dt >= 0)) return lose(view, motion, "the time went back");
  if (!in_time) return lose(view, motion, "no view came for " + numberText(std::round(10 * dt) / 10) + " s");
  return track(view, motion);
}

// The floor errs alike for a while: what it tells of roll, pitch and height is new by the way that the wheels
// have gone.
void PoseTracking::stand(const Eigen::Isometry3d& motion) {
  constexpr int kFloorModels = 20;
  constexpr double kTurningWheel = 0.2;  // way of a wheel by turning on the spot [m/rad]
  const double way = motion.translation().norm() + kTurningWheel * rotationAngle(motion.linear());
  if (!(way > 0)) return;
  const std::optional<FloorPlane> floor = surroundings_.floorNear(T_w_c_.T, kFloorModels, floor_covariance_);
  if (!floor) return;
  const double repeated = std::max(1.0, params_.floor_length / way);
  T_w_c_ = updatedByFloor(T_w_c_, *surroundings_.map().mounting, *floor, floor_covariance_, repeated);
}

TrackedPose PoseTracking::track(const View& view, const ViewMotion& motion) {
  T_w_c_ = moved(T_w_c_, motion.T_a_b);
  looks_.move(motion.T_a_b.T);
  stand(motion.T_a_b.T);
  if (exceeds(T_w_c_.P, params_.lost_rotation_deg, params_.lost_translation))
    return lose(view, motion, "the pose has become as uncertain as any");
  doubtful_ = doubtful_ || motion.broken || !confirmed_;
  Step step = align(view, T_w_c_);
  step.view_agreement = motion.agreement;
  const double agreement = share(step.of_map);

  std::string objection;
  if (step.is_judged && agreement < (doubtful_ ? params_.sure_map_agreement : params_.min_map_agreement))
    objection = "the map contradicts the view";
  else if (doubtful_ && !view.depth.empty() && !isSure(step))
    objection = motion.broken ? "the view contradicts the ones before" : "the map does not confirm the view";
  if (objection.empty()) {
    T_w_c_ = step.alignment.T_w_c;
    looks_.add(step.alignment.pairs, step.surroundings);
    bad_views_ = 0;
    if (isSure(step) || view.depth.empty()) doubtful_ = false;
  } else {
    if (bad_views_++ == 0) bad_since_ = stamp_;
    const bool enough =
        doubtful_ ? bad_views_ >= params_.max_bad_views : stamp_ - bad_since_ >= params_.patience;
    if (!confirmed_ || enough) return lose(view, motion, objection);
    step.alignment = {T_w_c_, {}, false};
  }
  const bool in_doubt = step.is_judged && agreement < params_.sure_map_agreement;
  const bool check = in_doubt && stamp_ >= next_check_;
  if (check && hasBetterPlace(view, step)) {
    TrackedPose out;
    out.state = TrackingState::lost;
    out.reason = "another place agrees better with the view";
    out.searched = true;
    return out;
  }
  TrackedPose out = answer(view, step);
  out.searched = check;
  if (!objection.empty()) {
    out.state = TrackingState::cannot_tell;
    out.reason = objection;
  } else if (!confirmed_) {
    if (out.state != TrackingState::tracking) return lose(view, motion, kUnconfirmed);
    out.state = TrackingState::localized;
    confirmed_ = ever_ = true;
  }
  return out;
}

// At a new place what is hidden does not count as nothing: most of the view must be seen in the map.
bool PoseTracking::isSure(const Step& step) const {
  constexpr double kSeen = 0.7;
  return step.is_judged && share(step.of_map) >= params_.sure_map_agreement &&
         step.of_map.agree >= kSeen * step.of_map.judged();
}

PoseTracking::Step PoseTracking::align(const View& view, const PoseWithCovariance& prior) const {
  Step step;
  step.surroundings = surroundings_.around(view, prior.T, params_.track_models);
  looks_.discount(step.surroundings);
  step.alignment = alignView(view, step.surroundings, prior, alignment_, inverse_depth_std_);
  step.alignment.T_w_c.P = discounted(prior.P, step.alignment.T_w_c.P, 1 / params_.correlated_views);
  step.of_map = compareWithAll(view.depth, step.alignment.T_w_c.T, step.surroundings.pictures, comparison_,
                               kFineColumns);
  if (view.depth.empty()) return step;
  const int grid = gridStep(view.depth, kFineColumns);
  const int pixels = (view.depth.camera.width / grid) * (view.depth.camera.height / grid);
  step.is_judged = step.of_map.agree + step.of_map.contradict >= params_.min_map_pixels * pixels;
  return step;
}

TrackedPose PoseTracking::answer(const View& view, const Step& step) const {
  TrackedPose out;
  out.T_w_c = step.alignment.T_w_c;
  out.probability = probability_;
  out.map_agreement = share(step.of_map);
  out.view_agreement = step.view_agreement;
  out.reason = freeDirections(*out.T_w_c, params_.free_rotation_deg, params_.free_translation);
  if (!out.reason.empty()) out.reason = "nothing in view fixes " + out.reason;
  if (view.segments.empty()) out.reason = "the view shows no planar segment";
  out.state = out.reason.empty() ? TrackingState::tracking : TrackingState::cannot_tell;

  // The model with most pairs; of several the first in the map.
  std::map<int, std::vector<SegmentPair>> of_model;
  for (const SegmentPair& p : step.alignment.pairs) {
    const Surroundings::Origin& origin = step.surroundings.origins[p.model];
    of_model[origin.view].push_back({p.scene, origin.segment, p.distance});
  }
  if (of_model.empty()) return out;
  const auto most = std::max_element(of_model.begin(), of_model.end(), [](const auto& a, const auto& b) {
    return a.second.size() < b.second.size();
  });
  Hypothesis match;
  match.model = most->first;
  match.pairs = most->second;
  match.T_m_c = surroundings_.map().models[match.model].T_w_m->inverse() * *out.T_w_c;
  match.T_w_c = out.T_w_c->T;
  match.probability = probability_;
  out.match = std::move(match);
  return out;
}

TrackedPose PoseTracking::lose(const View& view, const ViewMotion& motion, const std::string& reason) {
  active_ = confirmed_ = false;
  candidates_.clear();
  TrackedPose out = search(view, motion);
  if (out.reason.empty() || ever_) out.reason = reason;
  return out;
}

// What one view leaves open the next one may tell: places that views in a row find win over the others.
TrackedPose PoseTracking::search(const View& view, const ViewMotion& motion) {
  TrackedPose out;
  out.state = ever_ ? TrackingState::lost : TrackingState::searching;
  out.searched = true;
  if (motion.broken) candidates_.clear();
  for (LikelyPlace& place : candidates_) place.T_w_c = moved(place.T_w_c, motion.T_a_b);
  const std::vector<LikelyPlace> found = placesOf(view, out.reason);
  if (found.empty()) return out;
  const int models = static_cast<int>(surroundings_.map().models.size());
  candidates_ = candidates_.empty() ? found : placesOfBoth(candidates_, found, models);
  out.reason = "no place is likely enough";
  if (candidates_.empty()) return out;
  const LikelyPlace best = *std::max_element(
      candidates_.begin(), candidates_.end(),
      [](const LikelyPlace& a, const LikelyPlace& b) { return a.probability < b.probability; });
  out.probability = best.probability;
  if (!(best.probability >= params_.min_probability)) return out;
  out.reason = kUnconfirmed;
  begin(best);
  return out;
}

std::vector<LikelyPlace> PoseTracking::placesOf(const View& view, std::string& reason) const {
  const Localization found = localization_.localize(view);
  reason = found.reason;
  std::vector<LikelyPlace> places;
  for (const Hypothesis& h : found.hypotheses)
    if (h.T_w_c) places.push_back({*surroundings_.map().models[h.model].T_w_m * h.T_m_c, h.probability});
  return places;
}

void PoseTracking::begin(const LikelyPlace& place) {
  T_w_c_ = place.T_w_c;
  looks_.clear();
  probability_ = place.probability;
  candidates_.clear();
  bad_views_ = 0;
  active_ = true;
  confirmed_ = false;
}

// Compares the place that is tracked with what the whole map says; goes there if it is better.
bool PoseTracking::hasBetterPlace(const View& view, const Step& step) {
  constexpr double kSameTranslation = 0.3, kSameRotation = 5;  // [m, deg]
  next_check_ = stamp_ + params_.check_interval;
  std::string reason;
  const std::vector<LikelyPlace> places = placesOf(view, reason);
  const LikelyPlace* best = places.empty() ? nullptr : &places.front();
  if (!best || !(best->probability >= params_.min_probability)) return false;
  if (isNear(best->T_w_c.T, T_w_c_.T, kSameTranslation, kSameRotation)) return false;
  const Step there = align(view, best->T_w_c);
  if (!isSure(there) || !(share(there.of_map) > share(step.of_map))) return false;
  begin(*best);
  return true;
}

}  // namespace facetloc
