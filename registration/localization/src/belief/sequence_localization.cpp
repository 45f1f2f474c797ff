// SPDX-License-Identifier: BSD-3-Clause
#include "belief/place_belief.h"
#include "belief/smoothed_places.h"
#include "motion/camera_motion.h"
#include "shared/pose_radius.h"

#include <facetloc/localization/global_localization.h>
#include <facetloc/localization/sequence_localization.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace internal;
namespace {

// Of a view that stands alone against the best place, from which on the camera is elsewhere [nats].
constexpr double kContradiction = 1;

const GlobalLocalizationParams& withProbabilities(const GlobalLocalizationParams& params) {
  if (params.score.by_overlap)
    throw std::invalid_argument("score.by_overlap: overlaps have no probabilities, which a sequence needs");
  return params;
}

}  // namespace

struct SequenceLocalization::Impl {
  Impl(const std::shared_ptr<const Map>& map, const SequenceParams& the_params,
       const GlobalLocalizationParams& the_localization)
      : params(checked(the_params)),
        localization(map, withProbabilities(the_localization)),
        belief(map, the_localization, params),
        motion(params.odometry),
        prior(-the_localization.probability.priorLogOdds()) {}

  SequenceAnswer add(View&& view, double stamp, const std::optional<PoseWithCovariance>& given);
  void reset();
  bool isSure() const;
  bool isSure(double probability, const Matrix6d& P, int looks) const;
  bool isSureByItself(const Localization& found) const;
  void conclude(SequenceAnswer& answer) const;
  SequenceAnswer answer(const std::string& of_search) const;

  SequenceParams params;
  double min_probability = kMinProbability;
  GlobalLocalization localization;
  PlaceBelief belief;
  CameraMotion motion;
  double prior;            // log odds that the map holds a place
  bool by_itself = false;  // the latest view that was searched for is sure, and of the first place
  std::optional<double> stamp;
  Camera camera;  // of clouds and images
  std::optional<ViewBuilder> builder;
};

void SequenceLocalization::Impl::reset() {
  belief.clear();
  motion.reset();
  stamp.reset();
  by_itself = false;
}

bool SequenceLocalization::Impl::isSure(double probability, const Matrix6d& P, int looks) const {
  constexpr int kLeastLooks = 2;
  constexpr double kBound = 2;  // standard deviations, of 95 % of the errors
  return looks >= kLeastLooks && probability >= min_probability &&
         kBound * largestTranslationStd(P) <= params.max_translation &&
         kBound * largestRotationStd(P) <= params.max_rotation_deg * kDegree;
}

bool SequenceLocalization::Impl::isSure() const {
  if (belief.places().empty()) return false;
  const BelievedPlace& best = belief.places().front();
  return isSure(best.probability, best.T_w_c.P, belief.looks());
}

// A drive is as sure as an image that is sure of the same place.
bool SequenceLocalization::Impl::isSureByItself(const Localization& found) const {
  if (found.state(min_probability) != AnswerState::sure || belief.places().empty()) return false;
  const Hypothesis& best = found.hypotheses.front();
  const BelievedPlace& place = belief.places().front();
  return best.T_w_c && best.part == place.part && kSamePlace.joins(*best.T_w_c, place.T_w_c.T);
}

SequenceAnswer SequenceLocalization::Impl::add(View&& view_in, double now,
                                               const std::optional<PoseWithCovariance>& given) {
  const auto view = std::make_shared<const View>(std::move(view_in));
  const double dt = stamp ? now - *stamp : 0;
  const bool is_first = !stamp;
  stamp = now;
  std::string anew;
  if (!(dt >= 0)) anew = "the time went back";
  if (!anew.empty()) motion.reset();
  const Motion moved = motion.next(view, dt >= 0 ? dt : 0, is_first ? std::nullopt : given);
  if (!is_first && anew.empty() && moved.source == Motion::Source::broken)
    anew = "the view contradicts the one before";
  if (!anew.empty())
    belief.clear();
  else if (!is_first)
    belief.move(moved);

  // What shares nothing with the views before may be of any place: only the map can tell.
  const bool shows_anything = !view->segments.empty() || !view->depth.empty();
  const bool alone = shows_anything && !is_first && anew.empty() && !(moved.agreement > 0);
  std::string of_search;
  const bool searched = shows_anything && (alone || (belief.isDue() && !isSure()));
  if (shows_anything && (searched || belief.isDue() || moved.source != Motion::Source::seen))
    by_itself = false;
  if (searched) {
    const Localization found = localization.localize(*view, std::function<bool(int)>());
    of_search = found.reason;
    if (belief.look(view, &found, alone) < -kContradiction && alone) {
      anew = "the map contradicts the view, which has nothing in common with the one before";
      belief.clear();
      belief.look(view, &found);
    }
    by_itself = isSureByItself(found);
  } else if (shows_anything && belief.isDue()) {
    const std::vector<int> near = belief.modelsAround(4);
    const Localization found = localization.localize(
        *view, [&](int model) { return std::find(near.begin(), near.end(), model) == near.end(); });
    belief.look(view, &found);
  }
  if (getenv("BELIEF")) {
    fprintf(stderr,
            "%.3f dt %.2f motion %d modes %zu agree %.2f sd %.3f m %.2f deg searched %d alone %d anew '%s'\n",
            now, dt, int(moved.source), moved.modes.size(), moved.agreement,
            largestTranslationStd(moved.likeliest().P), largestRotationStd(moved.likeliest().P) / kDegree,
            searched, alone, anew.c_str());
    for (const BelievedPlace& q : belief.places())
      fprintf(stderr, "    p %.4f lo %.2f score %.1f t %.2f %.2f %.2f sd %.3f m %.2f deg model %d\n",
              q.probability, q.log_odds, q.match.score, q.T_w_c.T.translation().x(),
              q.T_w_c.T.translation().y(), q.T_w_c.T.translation().z(), largestTranslationStd(q.T_w_c.P),
              largestRotationStd(q.T_w_c.P) / kDegree, q.match.model);
  }
  SequenceAnswer out = answer(of_search);
  out.carried_away = !anew.empty();
  if (out.carried_away) out.reason = anew;
  out.searched = searched;
  out.T_before_now = moved.likeliest();
  return out;
}

SequenceAnswer SequenceLocalization::Impl::answer(const std::string& of_search) const {
  SequenceAnswer out;
  for (const BelievedPlace& place : belief.places()) {
    Hypothesis h = place.match;
    h.part = place.part;
    h.T_w_c = place.T_w_c.T;
    h.T_m_c = localization.map().models[h.model].T_w_m->inverse() * place.T_w_c;
    h.probability = place.probability;
    out.nowhere -= place.probability;
    out.places.push_back(std::move(h));
  }
  out.looks = belief.looks();
  conclude(out);
  if (by_itself) {
    out.state = AnswerState::sure;
    out.reason.clear();
  }
  if (out.places.empty() && !of_search.empty()) out.reason = of_search;
  return out;
}

// The state, and why it is not sure.
void SequenceLocalization::Impl::conclude(SequenceAnswer& answer) const {
  if (answer.places.empty()) {
    answer.reason = "no place agrees with the views";
    return;
  }
  const Hypothesis& best = answer.places.front();
  const PoseWithCovariance T_w_c = *localization.map().models[best.model].T_w_m * best.T_m_c;
  if (isSure(best.probability, T_w_c.P, answer.looks)) {
    answer.state = AnswerState::sure;
    return;
  }
  answer.state = AnswerState::doubtful;
  answer.reason =
      best.probability >= min_probability ? "the pose is too uncertain" : "no place is likely enough";
}

SequenceLocalization::SequenceLocalization(std::shared_ptr<const Map> map, const SequenceParams& params,
                                           const GlobalLocalizationParams& localization)
    : impl_(std::make_unique<Impl>(map, params, localization)) {}
SequenceLocalization::SequenceLocalization(SequenceLocalization&&) noexcept = default;
SequenceLocalization& SequenceLocalization::operator=(SequenceLocalization&&) noexcept = default;
SequenceLocalization::~SequenceLocalization() = default;

SequenceAnswer SequenceLocalization::add(View view, double stamp,
                                         const std::optional<PoseWithCovariance>& motion) {
  return impl_->add(std::move(view), stamp, motion);
}
SequenceAnswer SequenceLocalization::addImage(const DepthImage& image, double stamp,
                                              const std::optional<PoseWithCovariance>& motion) {
  const DepthImage small = workingImage(image);
  Camera seen = impl_->camera;
  seen.intrinsics = small.camera;
  if (!impl_->builder || !(impl_->builder->camera().intrinsics == small.camera))
    impl_->builder.emplace(impl_->localization.map().calibrated(seen));
  return impl_->add(impl_->builder->build(small), stamp, motion);
}
SequenceAnswer SequenceLocalization::smoothed(const SequenceAnswer& until_now,
                                              const SequenceAnswer& from_next,
                                              const PoseWithCovariance& T_now_next) const {
  SequenceAnswer out = smoothedPlaces(until_now, from_next, T_now_next, impl_->prior);
  impl_->conclude(out);
  const bool same = !out.places.empty() && !until_now.places.empty() &&
                    out.places.front().part == until_now.places.front().part &&
                    kSamePlace.joins(*out.places.front().T_w_c, *until_now.places.front().T_w_c);
  if (same && until_now.state == AnswerState::sure) {
    out.state = AnswerState::sure;
    out.reason.clear();
  }
  return out;
}
void SequenceLocalization::setCamera(const Camera& camera) {
  impl_->camera = camera;
  impl_->builder.reset();
}
void SequenceLocalization::setMinProbability(double p) {
  if (!(p > 0 && p <= 1)) throw std::invalid_argument("the least probability must be above 0 and at most 1");
  impl_->min_probability = p;
}
const Camera& SequenceLocalization::camera() const { return impl_->camera; }
void SequenceLocalization::reset() { impl_->reset(); }
void SequenceLocalization::setNumberOfThreads(int n) {
  impl_->localization.setNumberOfThreads(n);
  impl_->belief.setNumberOfThreads(n);
}

}  // namespace facetloc
