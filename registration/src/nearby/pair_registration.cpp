// SPDX-License-Identifier: BSD-3-Clause
#include "nearby/hypothesis_ranking.h"
#include "nearby/nearby_models.h"
#include "nearby/view_alignment.h"
#include "pairs/mounting_check.h"
#include "pairs/view_registration.h"

#include <facetloc/features/pose.h>
#include <facetloc/registration/pair_registration.h>
#include <facetloc/registration/pose_prior.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace internal;

namespace {

constexpr double kDoubtOfCoarse = 10;                  // against poses that planes alone do not fix [nats]
constexpr double kLeastAgreeing = 0.5;                 // share of the depth pixels that are compared
constexpr double kPriorPixels = 2;                     // added to counts of pixels
constexpr double kLeastOverlap = 0.02;                 // added to the share of pixels in common
constexpr double kGate = chiSquareQuantile(6, 0.999);  // gate of the prior

/** The only view near a hypothesis is the target, whose camera frame is the world. */
class PairRanking : public HypothesisRanking {
public:
  /** \param doubt that the score of planes has to overcome beyond the null score [nats] */
  PairRanking(std::shared_ptr<const View> target, const RegistrationParams& params, double doubt)
      : HypothesisRanking(params), target_(std::move(target)), params_(params), doubt_(doubt) {}

private:
  std::vector<NearbyView> neighbours(const Hypothesis& h) const override {
    const Eigen::Isometry3d T_w_m = poseOfModel(h);
    const bool shows =
        !target_->depth.empty() && std::isfinite(viewDistance(T_w_m, *h.T_w_c, kEvidenceReach));
    return shows ? std::vector<NearbyView>{{target_, T_w_m}} : std::vector<NearbyView>();
  }
  Eigen::Isometry3d poseOfModel(const Hypothesis&) const override { return Eigen::Isometry3d::Identity(); }
  int viewpoints(const std::vector<int>&) const override { return 1; }
  double evidenceWeight() const override { return params_.calibration.pair_probability.evidence_weight; }
  ScoreOdds odds(bool evidence, const std::vector<Hypothesis>&) const override {
    ScoreOdds odds = oddsOfPair(params_, evidence);
    odds.null_score += doubt_;
    return odds;
  }
  // Wrong poses explain planes by chance, but seldom all pixels that both views see (METHOD 10.6).
  double scoreByPixels(const View& scene, const Hypothesis& h) const override {
    const PairProbabilityCalibration& p = params_.calibration.pair_probability;
    const DepthComparison& compared = comparison(true);
    const Eigen::Isometry3d& T = h.T_m_c.T;
    const DepthAgreement seen = compared.count(scene.depth, target_->depth, T, kFineColumns),
                         back = compared.count(target_->depth, scene.depth, T.inverse(), kFineColumns);
    const auto share = [&](const DepthAgreement& a, const DepthPicture& of) {
      return a.judged() / std::max(1.0, double(compared.pixelsInReach(of, kFineColumns)));
    };
    const double agree = std::min(seen.agree, back.agree),
                 contradict = std::max(seen.contradict, back.contradict),
                 overlap = std::min(share(seen, scene.depth), share(back, target_->depth));
    const double log_odds =
        p.agreement_weight * std::log((agree + kPriorPixels) / (contradict + kPriorPixels)) +
        p.overlap_weight * std::log(overlap + kLeastOverlap) - p.pixels_null;
    return p.null_score + doubt_ + log_odds / p.slope;
  }

  std::shared_ptr<const View> target_;
  RegistrationParams params_;
  double doubt_;
};

void rankAll(const PairRanking& ranking, const View& view, std::vector<Hypothesis>& hypotheses) {
  for (Hypothesis& h : hypotheses) h.T_w_c = h.T_m_c.T;
  ranking.rank(view, hypotheses);
}

void check(const std::vector<SegmentPair>& pairs, const View& scene, const View& model) {
  for (const SegmentPair& p : pairs)
    if (p.scene < 0 || p.scene >= static_cast<int>(scene.segments.size()) || p.model < 0 ||
        p.model >= static_cast<int>(model.segments.size()))
      throw std::invalid_argument("a chosen pair names a segment that the view or the model does not have");
}

}  // namespace

struct PairRegistration::Impl {
  Impl(View the_target, const RegistrationParams& the_params)
      : target(std::make_shared<const View>(std::move(the_target))),
        params(checked(the_params)),
        registration(params) {
    if (target->camera) camera = *target->camera;
    if (params.steps.floor_information) of_floor = floorInformation(camera.mounting, params.prior);
  }

  /** Two views whose pixels mostly disagree do not show the same, however well some planes fit. */
  static bool agree(const Hypothesis& h) {
    return !(h.coverage.compared > 0 && h.coverage.agreeing < kLeastAgreeing);
  }

  /** Candidates where planes alone have no sure answer: poses that they leave open, by where their
   * segments are, and all of these and the prior itself moved to where planes and pixels fit best. */
  std::vector<Hypothesis> coarsePoses(const Query& query, const PoseWithCovariance& prior,
                                      const std::vector<SegmentPair>* chosen) const {
    std::vector<Hypothesis> poses = registration.alignByExtents(query, *target, prior, chosen);
    if (query.view.depth.empty() || target->depth.empty()) return poses;
    std::vector<PoseWithCovariance> starts{prior};
    for (const Hypothesis& h : poses) starts.push_back(h.T_m_c);
    LocalMap surroundings;
    surroundings.add(0, target, Eigen::Isometry3d::Identity());
    const ViewAlignmentParams alignment = alignmentWithCovariance(false, params.matching);
    for (const PoseWithCovariance& start : starts) {
      PoseWithCovariance found = alignView(query.view, surroundings, start, alignment).T_w_c;
      found = alignView(query.view, surroundings, {found.T, aboutStart()}, alignment).T_w_c;
      if (!(squaredMahalanobis(prior, found.T) <= kGate)) continue;  // pixels alone lead anywhere
      std::optional<Hypothesis> h = registration.alignFrom({found.T, aboutStart()}, query, *target, chosen);
      if (!h) continue;
      h->T_m_c = found;
      poses.push_back(std::move(*h));
    }
    return poses;
  }

  std::shared_ptr<const View> target;
  RegistrationParams params;
  ViewRegistration registration;
  Camera camera;                         // camera of the target
  Matrix6d of_floor = Matrix6d::Zero();  // information of the floor about a pose
};

PairRegistration::PairRegistration(View target, const RegistrationParams& params)
    : impl_(std::make_unique<Impl>(std::move(target), params)) {}
PairRegistration::PairRegistration(PairRegistration&&) noexcept = default;
PairRegistration& PairRegistration::operator=(PairRegistration&&) noexcept = default;
PairRegistration::~PairRegistration() = default;

const View& PairRegistration::target() const { return *impl_->target; }

Localization PairRegistration::align(const View& view, const PoseWithCovariance& prior,
                                     const std::vector<SegmentPair>* chosen, double doubt) const {
  Localization answer;
  answer.camera = differenceFrom(impl_->camera, view);
  answer.has_probabilities = impl_->registration.score().inNats();
  if (chosen) check(*chosen, view, *impl_->target);
  if (!prior.P.allFinite() || Eigen::LLT<Matrix6d>(prior.P).info() != Eigen::Success) {
    answer.reason = "the covariance of the prior is not positive definite";
    return answer;
  }
  const Query query(view, prior, answer.camera.sameMounting() ? impl_->of_floor : Matrix6d(Matrix6d::Zero()));
  if (impl_->registration.mayFixPose(query))
    answer.hypotheses = impl_->registration.align(query, *impl_->target, prior, chosen);
  const std::vector<Hypothesis> by_planes = answer.hypotheses;
  doubt /= impl_->params.calibration.pair_probability.slope;
  const PairRanking ranking(impl_->target, impl_->params, doubt);
  rankAll(ranking, view, answer.hypotheses);
  answer.decide();
  if (answer.state != AnswerState::sure) {
    const std::vector<Hypothesis> coarse = impl_->coarsePoses(query, prior, chosen);
    if (!coarse.empty()) {
      answer.hypotheses = by_planes;
      answer.hypotheses.insert(answer.hypotheses.end(), coarse.begin(), coarse.end());
      rankAll({impl_->target, impl_->params, doubt + kDoubtOfCoarse}, view, answer.hypotheses);
    }
  }
  ranking.stateAsShown(
      view, [&prior](int) { return prior; }, answer.hypotheses);
  concludePose(impl_->params.sure, answer);
  if (!answer.hypotheses.empty() && !Impl::agree(answer.hypotheses.front())) {
    answer.fixes_pose = false;
    answer.reason = "the depth of the two views disagrees at this pose";
  }
  if (answer.hypotheses.empty()) answer.reason = whyNoHypothesis(query, impl_->params.tree);
  answer.decide();
  return answer;
}

Localization PairRegistration::alignTurned(const View& view, const PoseWithCovariance& prior) const {
  Localization best;
  for (int quarter = 1; quarter < 4; ++quarter) {
    Localization answer = align(view, {prior.T * quarterTurns(quarter), prior.P});
    discountTurned(answer);
    answer.decide();
    const bool is_better = best.hypotheses.empty() ||
                           (!answer.hypotheses.empty() &&
                            answer.hypotheses.front().probability > best.hypotheses.front().probability);
    if (is_better) best = std::move(answer);
  }
  return best;
}

Localization PairRegistration::align(const View& view) const {
  PoseWithCovariance prior;
  const bool same_mounting = differenceFrom(impl_->camera, view).sameMounting();
  prior.P = posePrior(same_mounting ? impl_->camera.mounting : std::nullopt, impl_->params.prior);
  return align(view, prior);
}

}  // namespace facetloc
