// SPDX-License-Identifier: BSD-3-Clause
#include "global/place_belief.h"
#include "sequence/image_motion.h"

#include <facetloc/registration/global_localization.h>
#include <facetloc/registration/sequence_localization.h>
#include <facetloc/segmentation/view_builder.h>

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
        motion(params.odometry) {}

  SequenceAnswer add(View&& view, double stamp, const std::optional<PoseWithCovariance>& given);
  void reset();
  bool isSure() const;
  SequenceAnswer answer(const std::string& of_search) const;

  SequenceParams params;
  double min_probability = kMinProbability;
  GlobalLocalization localization;
  PlaceBelief belief;
  ImageMotion motion;
  std::optional<double> stamp;
  Camera camera;  // of clouds and images
  std::optional<ViewBuilder> builder;
};

void SequenceLocalization::Impl::reset() {
  belief.clear();
  motion.reset();
  stamp.reset();
}

bool SequenceLocalization::Impl::isSure() const {
  if (belief.places().empty() || belief.looks() < 2) return false;
  const BelievedPlace& best = belief.places().front();
  return best.probability >= min_probability &&
         largestTranslationStd(best.T_w_c.P) <= params.max_translation &&
         largestRotationStd(best.T_w_c.P) <= params.max_rotation_deg * kDegree;
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
  ViewMotion moved = motion.add(view, dt >= 0 ? dt : 0, is_first ? std::nullopt : given);
  if (!is_first && anew.empty() && moved.broken) anew = "the view contradicts the one before";
  if (!anew.empty())
    belief.clear();
  else if (!is_first)
    belief.move(moved.T_a_b);

  // What shares nothing with the views before may be of any place: only the map can tell.
  const bool shows_anything = !view->segments.empty() || !view->depth.empty();
  const bool alone = shows_anything && !is_first && anew.empty() && !(moved.agreement > 0);
  std::string of_search;
  const bool searched = shows_anything && (alone || (belief.isDue() && !isSure()));
  if (searched) {
    const Localization found = localization.localize(*view);
    of_search = found.reason;
    if (belief.look(view, &found, alone) < -kContradiction && alone) {
      anew = "the map contradicts the view, which has nothing in common with the one before";
      belief.clear();
      belief.look(view, &found);
    }
  } else if (shows_anything && belief.isDue()) {
    belief.look(view, nullptr);
  }
  SequenceAnswer out = answer(of_search);
  out.carried_away = !anew.empty();
  if (out.carried_away) out.reason = anew;
  out.searched = searched;
  out.T_before_now = moved.T_a_b;
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
  if (out.places.empty()) {
    out.reason = of_search.empty() ? "no place agrees with the views" : of_search;
  } else if (isSure()) {
    out.state = AnswerState::sure;
  } else {
    out.state = AnswerState::doubtful;
    out.reason = out.places.front().probability >= min_probability ? "the pose is too uncertain"
                                                                   : "no place is likely enough";
  }
  return out;
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
  constexpr int kWorkingWidth = 320;
  const DepthImage small = subsampled(image, subsamplingStep(image.camera, kWorkingWidth));
  Camera seen = impl_->camera;
  seen.intrinsics = small.camera;
  if (!impl_->builder || !(impl_->builder->camera().intrinsics == small.camera))
    impl_->builder.emplace(impl_->localization.map().calibrated(seen));
  return impl_->add(impl_->builder->build(small), stamp, motion);
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
