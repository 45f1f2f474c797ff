// SPDX-License-Identifier: BSD-3-Clause
#include "belief/next_look.h"
#include "belief/place_belief.h"
#include "belief/place_following.h"
#include "motion/camera_motion.h"
#include "poses/pose_fusion.h"
#include "ranking/global_localization.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/localization/localizer.h>
#include <facetloc/segmentation/view_builder.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace internal;
namespace {

// Evidence of a view that stands alone against the best place: beyond, the camera is elsewhere [nats].
constexpr double kContradiction = 1;
constexpr double kPatience = 1;       // with a map that contradicts the place that is followed [s]
constexpr double kCheckInterval = 2;  // between searches of the whole map while that place is in doubt [s]
constexpr double kWaiting = 1;        // between observations of a camera that stands and is not sure [s]
constexpr const char* kPlaceKnown = "the place is known, the pose is not: ";
constexpr double kJump = 0.01;           // probability of a jump from which on the whole map is searched
constexpr std::size_t kMostLooked = 24;  // searched views that are remembered: a turn in steps of 15 deg
constexpr double kLikely = 0.5;          // probability of a place that is still known, be it sure or not

void requireProbabilities(const GlobalLocalizationParams& params) {
  if (params.score.by_overlap)
    throw std::logic_error("score.by_overlap: overlaps have no probabilities, which a moving camera needs");
}

}  // namespace

struct Localizer::Impl {
  Impl(const std::shared_ptr<const Map>& the_map, const LocalizerParams& the_params,
       const GlobalLocalizationParams& the_localization)
      : map(the_map),
        params(checked(the_params)),
        localization_params(the_localization),
        errors(consideredErrorsOf(*the_map)),
        min_probability(minProbabilityOf(*the_map)),
        localization(the_map, the_localization),
        belief(the_map, the_localization, params),
        following(the_map, the_localization),
        motion(params.odometry) {}

  /** Intermediate results of one view. */
  struct Step {
    std::shared_ptr<const View> view;
    double now = 0;  // [s]
    Motion motion;
    bool is_first = false;
    bool shows_anything = false;
    bool alone = false;     // nothing but the map can tell whether it is where it is believed to be
    bool searched = false;  // the whole map
    std::string anew;       // why everything has begun anew
    std::string of_search;  // why a search has found nothing
    bool is_doubted = false, is_contradicted = false;  // the map contradicts the place that is followed
  };

  Localization update(View&& view, double stamp, const std::optional<PoseWithCovariance>& given);
  void move(Step& step, double dt, const std::optional<PoseWithCovariance>& given);
  void see(Step& step);
  void follow(Step& step);
  void search(Step& step);
  void lookAround(Step& step);
  void reset();
  void forget();  // the places and all that was seen there

  bool isLikely() const {
    return !belief.places().empty() && belief.places().front().probability >= min_probability;
  }
  bool isSure() const { return isLikely() && localization_params.sure.hold(belief.places().front().T_w_c.P); }
  /** Is a single view sure of a place? */
  bool isSure(const Localization& found) const {
    return found.stateAt(min_probability) == AnswerState::sure && found.hypotheses.front().T_w_c;
  }
  /** Is it the first place of the belief? */
  bool isFirst(const Hypothesis& h) const {
    if (belief.places().empty()) return false;
    const BelievedPlace& first = belief.places().front();
    return h.part == first.part && kSamePlace.joins(*h.T_w_c, first.T_w_c.T);
  }
  PoseWithCovariance poseOf(const Hypothesis& h) const { return *map->models[h.model].T_w_m * h.T_m_c; }
  void hear(const Localization& found);
  void list(const PlaceBelief& of, Localization& out) const;
  Localization localizeNear(const View& view, const PoseWithCovariance& T_w_c, int part) const;
  void requirePart(const PoseWithCovariance& T_w_c, int part) const;
  Localization answer(const Step& step);
  void share(double of_first, Localization& answer) const;
  void doubt(Localization& answer) const;
  void conclude(Localization& answer) const;
  bool isKnown(const Localization& answer) const;
  void track(Localization& answer);

  std::shared_ptr<const Map> map;
  LocalizerParams params;
  GlobalLocalizationParams localization_params;
  int threads = 1;
  ConsideredErrors errors;
  double min_probability;
  GlobalLocalization localization;
  PlaceBelief belief;
  PlaceFollowing following;
  CameraMotion motion;
  bool is_known = false, was_known = false;  // a place: since when it was sure, and ever
  std::optional<double> stamp, contradicted_since;
  double latest_observation = -std::numeric_limits<double>::infinity(),
         next_check = latest_observation;  // [s]
  double own_probability = 0;              // the first place by the latest observation alone, if sure
  std::optional<int> quarters;             // roll of the camera, once an image is sure of it
  int observations_unsearched = 0;         // observations since the whole map was searched
  std::vector<Eigen::Isometry3d> looked;   // poses of the latest searched views in the camera
  Camera camera;                           // camera of clouds and images
  std::optional<ViewBuilder> builder;
};

void Localizer::Impl::reset() {
  forget();
  motion.reset();
  stamp.reset();
  is_known = was_known = false;
  own_probability = 0;
}

void Localizer::Impl::forget() {
  belief.clear();
  following.clear();
  looked.clear();
  contradicted_since.reset();
  quarters.reset();
  latest_observation = next_check = -std::numeric_limits<double>::infinity();
}

Localization Localizer::Impl::update(View&& view, double now,
                                     const std::optional<PoseWithCovariance>& given) {
  requireProbabilities(localization_params);
  Step step;
  step.view = std::make_shared<const View>(std::move(view));
  step.now = now;
  step.shows_anything = !step.view->segments.empty() || !step.view->depth.empty();
  step.is_first = !stamp;
  const double dt = stamp ? now - *stamp : 0;
  stamp = now;
  const bool is_finite = given && given->T.matrix().allFinite() && given->P.allFinite();
  move(step, dt, is_finite ? given : std::nullopt);
  if (step.shows_anything)
    see(step);
  else
    own_probability = 0;
  return answer(step);
}

void Localizer::Impl::move(Step& step, double dt, const std::optional<PoseWithCovariance>& given) {
  if (!(dt >= 0)) {
    step.anew = "the time went back";
    motion.reset();
  }
  step.motion = motion.next(step.view, dt >= 0 ? dt : 0, step.is_first ? std::nullopt : given);
  if (step.is_first) return;
  if (step.anew.empty() && step.motion.source == Motion::Source::broken)
    step.anew = "the view contradicts the one before";
  if (!step.anew.empty()) return forget();
  const Eigen::Isometry3d T_a_b = step.motion.likeliest().T;
  belief.move(step.motion);
  following.move(T_a_b);
  for (Eigen::Isometry3d& T_now_then : looked) T_now_then = T_a_b.inverse() * T_now_then;
  // A view that shares nothing with the views before may be of any place: only the map can tell.
  step.alone = step.shows_anything && !(step.motion.agreement > 0);
  if (!isLikely()) return;
  const BelievedPlace& place = belief.places().front();
  belief.correct(following.onFloor(*step.view, place.part, place.T_w_c, T_a_b));
}

void Localizer::Impl::see(Step& step) {
  const bool waited = step.now - latest_observation >= kWaiting && !isSure();
  const bool may_have_jumped = step.motion.none > kJump;
  const bool is_due = step.alone || waited || may_have_jumped || belief.isDue();
  if (is_due || step.motion.source != Motion::Source::seen) own_probability = 0;
  if (!is_due && isLikely()) follow(step);
  const bool check = step.is_doubted && step.now >= next_check;
  if (step.alone || check || may_have_jumped || (is_due && !isSure()))
    search(step);
  else if (is_due)
    lookAround(step);
}

// Between observations.
void Localizer::Impl::follow(Step& step) {
  const BelievedPlace& place = belief.places().front();
  const FollowedPlace seen = following.at(*step.view, place.part, place.T_w_c);
  step.is_doubted = seen.isInDoubt();
  step.is_contradicted = seen.isContradicted();
  if (!step.is_contradicted) {
    contradicted_since.reset();
    belief.correct(seen.alignment.T_w_c, following.match(seen, place.part));
    following.accept(seen);
    return;
  }
  if (!contradicted_since) contradicted_since = step.now;
  if (step.now - *contradicted_since < kPatience) return;
  step.alone = true;
  contradicted_since.reset();
}

void Localizer::Impl::search(Step& step) {
  step.searched = true;
  const Localization found = localization.localize(*step.view, {}, quarters);
  step.of_search = found.reason;
  const std::optional<double> of_best = belief.observe(step.view, found, step.alone);
  const bool is_elsewhere = of_best ? *of_best < -kContradiction : isSure(found);
  if (step.alone && !step.is_first && is_elsewhere && !(isSure(found) && isFirst(found.hypotheses.front()))) {
    step.anew = "the map contradicts the view";
    forget();
    belief.observe(step.view, found);
  }
  hear(found);
  if (looked.size() == kMostLooked) looked.erase(looked.begin());
  looked.push_back(Eigen::Isometry3d::Identity());
  latest_observation = step.now;
  next_check = step.now + kCheckInterval;
  observations_unsearched = 0;
}

// A drive is as sure as an image that is sure of the same place.
void Localizer::Impl::hear(const Localization& found) {
  if (!isSure(found)) return;
  const Hypothesis& best = found.hypotheses.front();
  belief.hear(best);
  if (isFirst(best)) own_probability = best.probability;
}

// Registers the view near each place, where it may fit better. Now and then the whole map is asked, whose
// answer is heard if the view is sure of it.
void Localizer::Impl::lookAround(Step& step) {
  constexpr int kNearModels = 4;
  constexpr int kListening = 3;  // observations between searches of the whole map while a place is sure
  latest_observation = step.now;
  if (++observations_unsearched >= kListening) {
    observations_unsearched = 0;
    step.searched = true;
    const Localization found = localization.localize(*step.view, {}, quarters);
    if (isSure(found)) {
      belief.observe(step.view, found);
      return hear(found);
    }
  }
  const std::vector<int> near = belief.modelsAround(kNearModels);
  const auto isFar = [&](int model) { return std::find(near.begin(), near.end(), model) == near.end(); };
  const Localization found = localization.localize(*step.view, isFar, quarters);
  belief.observe(step.view, found);
}

// The places of a belief, most probable first, each with the errors that no number of views averages out.
void Localizer::Impl::list(const PlaceBelief& of, Localization& out) const {
  double left = 1;
  for (const BelievedPlace& place : of.places()) {
    Hypothesis h = place.match;
    h.part = place.part;
    h.T_w_c = place.T_w_c.T;
    h.T_m_c = map->models[h.model].T_w_m->inverse() * place.T_w_c;
    h.T_m_c.P = withSharedErrors(h.T_m_c.P, errors.rotation_std, errors.translation_std);
    h.probability = place.probability;
    left -= place.probability;
    out.hypotheses.push_back(std::move(h));
  }
  out.not_in_map = std::max(0.0, left);
  out.looks = of.observations();
}

// A belief of its own, that begins there, takes the view. The given pose counts as an observation: with the
// view, they are two that agree.
Localization Localizer::Impl::localizeNear(const View& view, const PoseWithCovariance& T_w_c,
                                           int part) const {
  requireProbabilities(localization_params);
  requirePart(T_w_c, part);
  PlaceBelief near(map, localization_params, params);
  near.setNumberOfThreads(threads);
  near.inject(part, T_w_c, kMostLogOdds);
  std::optional<int> any_roll;
  const Localization found = localization.localize(view, {}, any_roll);
  near.observe(std::make_shared<const View>(view), found);
  Localization out;
  list(near, out);
  out.searched = true;
  conclude(out);
  out.shares = localization.shares(view, out);
  if (out.hypotheses.empty() && !found.reason.empty()) out.reason = found.reason;
  return out;
}

// Throws unless a camera may be said to be there.
void Localizer::Impl::requirePart(const PoseWithCovariance& T_w_c, int part) const {
  const bool is_finite = T_w_c.T.matrix().allFinite() && T_w_c.P.allFinite();
  if (!is_finite || Eigen::LLT<Matrix6d>(T_w_c.P).info() != Eigen::Success)
    throw std::invalid_argument("the covariance of a pose must be positive definite, and all numbers finite");
  if (std::none_of(map->models.begin(), map->models.end(),
                   [part](const LocalModel& m) { return m.part == part && m.T_w_m; }))
    throw std::invalid_argument("the map has no such part with poses");
}

Localization Localizer::Impl::answer(const Step& step) {
  Localization out;
  list(belief, out);
  out.searched = step.searched;
  out.began_anew = !step.anew.empty();
  out.T_before_now = step.motion.likeliest();
  if (!out.hypotheses.empty() && out.hypotheses.front().probability < own_probability)
    share(own_probability, out);
  if (step.is_contradicted && !step.searched) doubt(out);
  conclude(out);
  if (step.is_contradicted && !step.searched && out.state != AnswerState::sure)
    out.reason = "the map contradicts the view";
  if (out.hypotheses.empty() && !step.of_search.empty()) out.reason = step.of_search;
  if (!step.shows_anything && out.state != AnswerState::sure) out.reason = "the view shows no planar segment";
  if (std::none_of(map->models.begin(), map->models.end(),
                   [](const LocalModel& m) { return m.T_w_m.has_value(); }))
    out.reason = "no local model of the map has a pose";
  track(out);
  if (out.began_anew) out.reason = step.anew;
  out.shares = localization.shares(*step.view, out);
  return out;
}

// Gives the first place a probability; the others and nowhere share the rest.
void Localizer::Impl::share(double of_first, Localization& answer) const {
  const double scale = (1 - of_first) / (1 - answer.hypotheses.front().probability);
  for (Hypothesis& h : answer.hypotheses) h.probability *= scale;
  answer.hypotheses.front().probability = of_first;
  answer.not_in_map = *answer.not_in_map * scale;
}

// A place that the view contradicts is as likely as not, until the whole map has been asked.
void Localizer::Impl::doubt(Localization& answer) const {
  constexpr double kContradicted = 0.5;
  double sum = 0;
  for (Hypothesis& h : answer.hypotheses) sum += h.probability *= kContradicted;
  answer.not_in_map = 1 - sum;
}

// The state, and why it is not sure.
void Localizer::Impl::conclude(Localization& answer) const {
  if (answer.hypotheses.empty()) {
    answer.reason = "no place agrees with the views";
    return;
  }
  const PoseLimits& limits = localization_params.sure;
  const Hypothesis& best = answer.hypotheses.front();
  const Matrix6d P = poseOf(best).P;
  answer.fixes_pose = limits.hold(P);
  answer.state = answer.stateAt(min_probability);
  answer.reason.clear();
  if (answer.state == AnswerState::unknown)
    answer.reason = kNotInMap;
  else if (!(best.probability >= min_probability))
    answer.reason = "no place is likely enough";
  else if (answer.state != AnswerState::sure)
    answer.reason = kPlaceKnown + limits.whyNotFixed(P, best.T_w_c->linear().transpose());
}

// No more of the pose is unknown than of one that is beside a local model (paper II.B).
bool Localizer::Impl::isKnown(const Localization& answer) const {
  if (answer.hypotheses.empty() || answer.hypotheses.front().probability < kLikely) return false;
  const Matrix6d P = poseOf(answer.hypotheses.front()).P;
  return largestTranslationStd(P) <= localization_params.prior.translation_std &&
         largestRotationStd(P) <= localization_params.prior.rotation_std_deg * kDegree;
}

// The state for live programs: a place is known from when it is sure on, as long as it is likely.
void Localizer::Impl::track(Localization& answer) {
  const bool sure = answer.state == AnswerState::sure;
  const bool was_followed = is_known && !answer.began_anew;
  is_known = sure || (was_followed && isKnown(answer));
  was_known = was_known || is_known;
  if (sure)
    answer.tracking = was_followed ? TrackingState::tracking : TrackingState::localized;
  else if (is_known)
    answer.tracking = TrackingState::degenerate;
  else
    answer.tracking = was_known ? TrackingState::lost : TrackingState::searching;
  if (is_known) answer.T_w_c = poseOf(answer.hypotheses.front());
  if (is_known) answer.T_w_c->T = *answer.hypotheses.front().T_w_c;
}

Localizer::Localizer(std::shared_ptr<const Map> map, const LocalizerParams& params,
                     const GlobalLocalizationParams& localization)
    : impl_(std::make_unique<Impl>(map, params, localization)) {}
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;
Localizer::~Localizer() = default;

Localization Localizer::localize(const View& view) const {
  Localization out = impl_->localization.localize(view);
  out.decide(impl_->min_probability);
  if (out.state == AnswerState::unknown && !out.hypotheses.empty()) out.reason = kNotInMap;
  if (out.state == AnswerState::doubtful && !out.reason.empty())
    out.reason = out.hypotheses.front().probability >= impl_->min_probability ? kPlaceKnown + out.reason : "";
  out.searched = true;
  out.shares = impl_->localization.shares(view, out);
  return out;
}
Localization Localizer::localize(const View& view, const PoseWithCovariance& T_w_c, int part) const {
  return impl_->localizeNear(view, T_w_c, part);
}
std::optional<NextLook> Localizer::nextLook(const View& view, const Localization& answer) const {
  std::vector<Eigen::Isometry3d> looked = {Eigen::Isometry3d::Identity()};
  if (answer.looks > 1) looked = impl_->looked;  // it is of the drive
  return internal::nextLook(impl_->map, impl_->localization_params, view, answer, looked,
                            impl_->min_probability);
}
Localization Localizer::update(View view, double stamp, const std::optional<PoseWithCovariance>& motion) {
  return impl_->update(std::move(view), stamp, motion);
}
Localization Localizer::update(const DepthImage& image, double stamp,
                               const std::optional<PoseWithCovariance>& motion) {
  Camera seen = impl_->camera;
  seen.intrinsics = image.camera;
  if (!impl_->builder || !(impl_->builder->camera().intrinsics == seen.intrinsics))
    impl_->builder.emplace(impl_->map->calibrated(seen), ViewParams(), kWorkingWidth);
  return impl_->update(impl_->builder->build(image), stamp, motion);
}
std::vector<Localization> Localizer::smoothed(const std::vector<DriveView>& drive,
                                              const std::function<void()>& done) const {
  Localizer backward(impl_->map, impl_->params, impl_->localization_params);
  backward.setNumberOfThreads(impl_->threads);
  const std::size_t n = drive.size();
  std::vector<Localization> from_here(n);
  for (std::size_t i = n; i-- > 0;) {
    std::optional<PoseWithCovariance> motion;  // back from the next view
    if (i + 1 < n && drive[i + 1].motion) motion = inverse(*drive[i + 1].motion);
    from_here[i] = backward.update(drive[i].view, -drive[i].stamp, motion);
    if (done) done();
  }
  const double prior = -impl_->localization_params.probability.priorLogOdds();
  std::vector<Localization> by_all;
  for (std::size_t i = 0; i < n; ++i) {
    by_all.push_back(drive[i].answer);
    if (i + 1 == n || drive[i + 1].answer.began_anew)
      continue;  // nothing that comes later is known to be near
    by_all[i] = smoothedPlaces(drive[i].answer, from_here[i + 1], drive[i + 1].answer.T_before_now, prior);
    impl_->conclude(by_all[i]);
    by_all[i].shares = impl_->localization.shares(drive[i].view, by_all[i]);
  }
  return by_all;
}
void Localizer::setCamera(const Camera& camera) {
  impl_->camera = camera;
  impl_->builder.reset();
}
void Localizer::setMinProbability(double p) {
  if (!(p > 0 && p <= 1)) throw std::invalid_argument("the least probability must be above 0 and at most 1");
  impl_->min_probability = p;
}
const Camera& Localizer::camera() const { return impl_->camera; }
void Localizer::reset() { impl_->reset(); }
void Localizer::setPose(const PoseWithCovariance& T_w_c, int part) {
  impl_->requirePart(T_w_c, part);
  impl_->reset();
  impl_->belief.inject(part, T_w_c, kMostLogOdds);
}
void Localizer::setNumberOfThreads(int n) {
  impl_->threads = n;
  impl_->localization.setNumberOfThreads(n);
  impl_->belief.setNumberOfThreads(n);
}

std::map<std::string, double> probabilitiesOfMaps(const Localization& answer, const Map& map) {
  std::map<std::string, double> out;
  for (const JoinedMap& one : map.joined) out[one.name] = 0;
  for (const Hypothesis& h : answer.hypotheses)
    if (const JoinedMap* one = map.joinedMap(h.part)) out[one->name] += h.probability;
  return out;
}

}  // namespace facetloc
