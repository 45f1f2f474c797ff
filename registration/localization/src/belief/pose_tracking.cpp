// SPDX-License-Identifier: BSD-3-Clause
#include "belief/map_surroundings.h"
#include "belief/place_belief.h"
#include "belief/repeated_looks.h"
#include "motion/view_odometry.h"
#include "ranking/place_ranking.h"
#include "shared/pose_fusion.h"

#include <facetloc/localization/global_localization.h>
#include <facetloc/localization/pose_tracking.h>
#include <facetloc/registration/pose_prior.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <vector>

namespace facetloc {

using namespace internal;
namespace {

constexpr int kModels = 5;              // nearest local models that a view is aligned with
constexpr int kDenseIterations = 4;     // of the alignment by all pixels
constexpr double kCorrelatedViews = 2;  // that count as one independent view: they see the same models alike
constexpr double kFloorLength = 0.7;    // way after which a robot on wheels stands on other unevenness [m]
// Std from which on the pose is unknown, half the paper's 0.2 m, and at which nothing is left to track, the
// paper's prior.
constexpr double kFreeTranslation = 0.1, kFreeRotationDeg = 2;   // [m]
constexpr double kLostTranslation = 1.0, kLostRotationDeg = 20;  // [m]
constexpr double kLeastAgreement = 0.6;  // share of the depth pixels that the map must confirm
constexpr double kKnownPixels = 0.1;     // share of them that must be in the map for it to object
constexpr double kSureAgreement = 0.85;  // agreement of a place that is new, and of one that is beyond doubt
constexpr int kMostBadViews = 3;         // in a row at a place in doubt, until the camera is lost
constexpr double kPatience = 1.0;        // with a map that contradicts while the camera's views agree [s]

constexpr const char* kUnconfirmed = "a likely place waits for the next view to confirm it";

bool exceeds(const Matrix6d& P, double rotation_deg, double translation) {
  return !(largestRotationStd(P) <= rotation_deg * kDegree && largestTranslationStd(P) <= translation);
}

// What is hidden from the other camera says nothing.
double share(const DepthAgreement& a) {
  return a.agree + a.contradict > 0 ? a.agree / double(a.agree + a.contradict) : 0;
}

ViewAlignmentParams alignmentParams(const MatchingParams& matching) {
  ViewAlignmentParams params = alignmentWithCovariance();
  params.matching = matching;
  params.dense.iterations = kDenseIterations;
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

struct PoseTracking::Impl {
  Impl(const std::shared_ptr<const Map>& map, const PoseTrackingParams& params,
       const GlobalLocalizationParams& localization);

  TrackedPose update(const View& view, double stamp, const std::optional<Eigen::Isometry3d>& given);
  void relocalize();

  struct Step;  // a view at its place in the map

  TrackedPose track(const View& view, const ViewMotion& motion);
  void stand(const Eigen::Isometry3d& motion);
  TrackedPose search(const View& view);
  TrackedPose lose(const View& view, const std::string& reason);
  TrackedPose answer(const View& view, const Step& step) const;
  void begin(const BelievedPlace& place);
  bool hasBetterPlace(const View& view, const Step& step);
  std::optional<BelievedPlace> likeliestPlace(const View& view, std::string& reason);
  BelievedPlace placeOf(const Hypothesis& h) const;
  bool isSure(const Step& step) const;
  Step align(const View& view, int part, const PoseWithCovariance& prior) const;

  PoseTrackingParams params_;
  GlobalLocalization localization_;
  MapSurroundings surroundings_;
  PlaceBelief belief_;
  Eigen::Matrix3d floor_covariance_;  // of (roll, pitch, height)
  ViewAlignmentParams alignment_;
  DepthComparison comparison_;
  ViewOdometry odometry_;
  RepeatedLooks looks_;
  PoseWithCovariance T_w_c_;
  int part_ = 0;  // of the map, in whose frame that is
  double stamp_ = 0;
  double probability_ = 0;
  double bad_since_ = 0, next_check_ = 0;  // [s]
  int bad_views_ = 0;
  bool active_ = false;     // there is a pose
  bool confirmed_ = false;  // and a second view has agreed with it
  bool doubtful_ = false;   // the camera has jumped; only a sure agreement with the map counts
  bool ever_ = false;       // there has been one
  bool on_floor_ = false;   // the camera of the latest view is mounted as the map's
};

struct PoseTracking::Impl::Step {
  ViewAlignment alignment;
  Surroundings surroundings;
  DepthAgreement of_map;
  double view_agreement = 0;

  bool is_judged = false;  // the map knows enough of them
};

PoseTracking::Impl::Impl(const std::shared_ptr<const Map>& map, const PoseTrackingParams& params,
                         const GlobalLocalizationParams& localization)
    : params_(checked(params)),
      localization_(map, localization),
      surroundings_(map, DepthComparison(localization.calibration.depth)),
      belief_(map, localization, SequenceParams{}),
      floor_covariance_(floorCovariance(localization.prior)),
      alignment_(alignmentParams(localization.matching)),
      comparison_(refinedErrors(localization.calibration)),
      odometry_(params.odometry, alignment_, comparison_) {}

PoseTracking::PoseTracking(std::shared_ptr<const Map> map, const PoseTrackingParams& params,
                           const GlobalLocalizationParams& localization)
    : impl_(std::make_unique<Impl>(map, params, localization)) {}
PoseTracking::PoseTracking(PoseTracking&&) noexcept = default;
PoseTracking& PoseTracking::operator=(PoseTracking&&) noexcept = default;
PoseTracking::~PoseTracking() = default;

TrackedPose PoseTracking::update(const View& view, double stamp,
                                 const std::optional<Eigen::Isometry3d>& motion) {
  return impl_->update(view, stamp, motion);
}
void PoseTracking::relocalize() { impl_->relocalize(); }
void PoseTracking::setNumberOfThreads(int n) {
  impl_->localization_.setNumberOfThreads(n);
  impl_->belief_.setNumberOfThreads(n);
}

void PoseTracking::Impl::relocalize() {
  active_ = confirmed_ = ever_ = false;
  belief_.clear();
}

TrackedPose PoseTracking::Impl::update(const View& view, double stamp,
                                       const std::optional<Eigen::Isometry3d>& given) {
  const double dt = stamp - stamp_;
  stamp_ = stamp;
  if (!surroundings_.anyPose()) {
    TrackedPose out;
    out.reason = "no local model of the map has a pose";
    return out;
  }
  std::optional<PoseWithCovariance> by_odometry;
  if (given && given->matrix().allFinite())
    by_odometry =
        motionByOdometry(*given, view.camera ? view.camera->mounting : std::nullopt, params_.odometry_error);
  const bool in_time = dt >= 0 && (by_odometry || dt <= params_.max_gap);
  if (!in_time) odometry_.reset();
  if (dt < 0) next_check_ = stamp;
  on_floor_ = view.camera && differenceOf(*view.camera, surroundings_.map().camera).sameMounting();
  ViewMotion motion = odometry_.add(view, in_time ? dt : 0, by_odometry);
  motion.broken = motion.broken || !in_time;
  if (motion.broken)
    belief_.clear();
  else
    belief_.move(Motion::known(motion.T_a_b, motion.agreement));
  if (!active_) return search(view);
  if (!(dt >= 0)) return lose(view, "the time went back");
  if (!in_time) return lose(view, fmt::format("no view came for {} s", numberText(std::round(10 * dt) / 10)));
  return track(view, motion);
}

// The floor errs alike for a while: what it tells of roll, pitch and height is new by the way that the wheels
// have gone.
void PoseTracking::Impl::stand(const Eigen::Isometry3d& motion) {
  constexpr int kFloorModels = 20;
  constexpr double kTurningWheel = 0.2;  // way of a wheel by turning on the spot [m/rad]
  const double way = motion.translation().norm() + kTurningWheel * rotationAngle(motion.linear());
  if (!(way > 0) || !on_floor_) return;
  const std::optional<FloorPlane> floor =
      surroundings_.floorNear(part_, T_w_c_.T, kFloorModels, floor_covariance_);
  if (!floor) return;
  const double repeated = std::max(1.0, kFloorLength / way);
  T_w_c_ = updatedByFloor(T_w_c_, *surroundings_.map().camera.mounting, *floor, floor_covariance_, repeated);
}

TrackedPose PoseTracking::Impl::track(const View& view, const ViewMotion& motion) {
  T_w_c_ = T_w_c_ * motion.T_a_b;
  looks_.move(motion.T_a_b.T);
  stand(motion.T_a_b.T);
  if (exceeds(T_w_c_.P, kLostRotationDeg, kLostTranslation))
    return lose(view, "the pose has become as uncertain as any");
  doubtful_ = doubtful_ || motion.broken || !confirmed_;
  Step step = align(view, part_, T_w_c_);
  step.view_agreement = motion.agreement;
  const double agreement = share(step.of_map);

  std::string objection;
  if (step.is_judged && agreement < (doubtful_ ? kSureAgreement : kLeastAgreement))
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
    const bool enough = doubtful_ ? bad_views_ >= kMostBadViews : stamp_ - bad_since_ >= kPatience;
    if (!confirmed_ || enough) return lose(view, objection);
    step.alignment = {T_w_c_, {}, false};
  }
  const bool in_doubt = step.is_judged && agreement < kSureAgreement;
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
    if (out.state != TrackingState::tracking) return lose(view, kUnconfirmed);
    out.state = TrackingState::localized;
    confirmed_ = ever_ = true;
  }
  return out;
}

// At a new place what is hidden does not count as nothing: most of the view must be seen in the map.
bool PoseTracking::Impl::isSure(const Step& step) const {
  constexpr double kSeen = 0.7;
  return step.is_judged && share(step.of_map) >= kSureAgreement &&
         step.of_map.agree >= kSeen * step.of_map.judged();
}

PoseTracking::Impl::Step PoseTracking::Impl::align(const View& view, int part,
                                                   const PoseWithCovariance& prior) const {
  Step step;
  step.surroundings = surroundings_.around(view, part, prior.T, kModels);
  looks_.discount(step.surroundings);
  step.alignment = alignView(view, step.surroundings, prior, alignment_);
  step.alignment.T_w_c.P = discounted(prior.P, step.alignment.T_w_c.P, 1 / kCorrelatedViews);
  step.of_map = compareWithAll(view.depth, step.alignment.T_w_c.T, step.surroundings.pictures, comparison_,
                               kFineColumns);
  if (view.depth.empty()) return step;
  const int grid = gridStep(view.depth, kFineColumns);
  const int pixels = (view.depth.camera.width / grid) * (view.depth.camera.height / grid);
  step.is_judged = step.of_map.agree + step.of_map.contradict >= kKnownPixels * pixels;
  return step;
}

TrackedPose PoseTracking::Impl::answer(const View& view, const Step& step) const {
  TrackedPose out;
  out.T_w_c = step.alignment.T_w_c;
  out.part = part_;
  out.probability = probability_;
  out.map_agreement = share(step.of_map);
  out.view_agreement = step.view_agreement;
  const Eigen::Matrix3d R_c_w = out.T_w_c->T.linear().transpose();
  out.reason = freeMotions(principalStd(out.T_w_c->P), kFreeRotationDeg * kDegree, kFreeTranslation, R_c_w);
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
  match.part = part_;
  match.probability = probability_;
  out.match = std::move(match);
  return out;
}

TrackedPose PoseTracking::Impl::lose(const View& view, const std::string& reason) {
  active_ = confirmed_ = false;
  belief_.clear();
  TrackedPose out = search(view);
  if (out.reason.empty() || ever_) out.reason = reason;
  return out;
}

// What one view leaves open the next ones may tell.
TrackedPose PoseTracking::Impl::search(const View& view) {
  TrackedPose out;
  out.state = ever_ ? TrackingState::lost : TrackingState::searching;
  out.searched = true;
  const std::optional<BelievedPlace> best = likeliestPlace(view, out.reason);
  for (const BelievedPlace& place : belief_.places())
    out.places.push_back({place.T_w_c, place.part, place.probability});
  if (!best) return out;
  out.probability = best->probability;
  out.reason = "no place is likely enough";
  if (!(best->probability >= params_.min_probability)) return out;
  out.reason = kUnconfirmed;
  begin(*best);
  return out;
}

// By all views since nothing was known, or by this one alone: the next view will have to confirm it.
std::optional<BelievedPlace> PoseTracking::Impl::likeliestPlace(const View& view, std::string& reason) {
  const Localization found = localization_.localize(view, std::function<bool(int)>());
  reason = found.reason;
  const bool shows_anything = !view.segments.empty() || !view.depth.empty();
  if (shows_anything && belief_.isDue()) belief_.look(std::make_shared<const View>(view), &found);
  std::optional<BelievedPlace> best;
  if (!belief_.places().empty()) best = belief_.places().front();
  const bool has_place = !found.hypotheses.empty() && found.hypotheses.front().T_w_c;
  if (has_place && (!best || found.hypotheses.front().probability > best->probability))
    best = placeOf(found.hypotheses.front());
  return best;
}

BelievedPlace PoseTracking::Impl::placeOf(const Hypothesis& h) const {
  BelievedPlace place;
  place.T_w_c = *surroundings_.map().models[h.model].T_w_m * h.T_m_c;
  place.part = h.part;
  place.probability = h.probability;
  return place;
}

void PoseTracking::Impl::begin(const BelievedPlace& place) {
  T_w_c_ = place.T_w_c;
  part_ = place.part;
  looks_.clear();
  probability_ = place.probability;
  bad_views_ = 0;
  active_ = true;
  confirmed_ = false;
}

// Compares the place that is tracked with the others where the camera may be; goes there if one is better.
bool PoseTracking::Impl::hasBetterPlace(const View& view, const Step& step) {
  next_check_ = stamp_ + params_.check_interval;
  belief_.suppose(part_, T_w_c_);
  std::string ignored;
  const std::optional<BelievedPlace> best = likeliestPlace(view, ignored);
  if (!best || !(best->probability >= params_.min_probability)) return false;
  const bool is_known = best->part == part_ && kSameAnswer.joins(best->T_w_c.T, T_w_c_.T);
  if (is_known) return false;
  const Step there = align(view, best->part, best->T_w_c);
  if (!isSure(there) || !(share(there.of_map) > share(step.of_map))) return false;
  begin(*best);
  return true;
}

}  // namespace facetloc
