// SPDX-License-Identifier: BSD-3-Clause
#include "nearby/hypothesis_ranking.h"

#include "depth/dense_refinement.h"
#include "depth/depth_fit.h"
#include "pairs/consensus.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace facetloc {
namespace internal {

// Evidence of several models about one world pose: all together about each pixel of the scene, and one by one
// about their own pixels, moved into the scene.
struct DepthEvidence {
  DepthAgreement of_scene;
  int pixels = 0;    // pixels of the scene
  int expected = 0;  // pixels among these that could agree
  std::vector<DepthAgreement> of_models;

  DepthAgreement ofAllModels() const {
    DepthAgreement sum;
    for (const DepthAgreement& of_model : of_models) sum += of_model;
    return sum;
  }
};

namespace {

constexpr double kBound = 2;        // standard deviations, of 95 % of the errors
constexpr int kRefinedPlaces = 12;  // best places that are refined, a limit of time

std::vector<PosedPicture> picturesOf(const std::vector<NearbyView>& views) {
  std::vector<PosedPicture> pictures;
  for (const NearbyView& n : views) pictures.push_back({&n.view->depth, n.T_w_m});
  return pictures;
}

// Evidence of one picture of the scene.
DepthEvidence ofPicture(const DepthPicture& scene, const Eigen::Isometry3d& T_w_c,
                        const std::vector<NearbyView>& neighbours, const DepthComparison& comparison) {
  DepthEvidence found;
  for (const NearbyView& n : neighbours)
    found.of_models.push_back(
        comparison.count(n.view->depth, scene, (n.T_w_m.inverse() * T_w_c).inverse(), kCoarseColumns));
  found.of_scene = compareWithAll(scene, T_w_c, picturesOf(neighbours), comparison, kFineColumns);
  const int step = gridStep(scene, kFineColumns);
  found.pixels = gridPoints(scene.camera.width, step) * gridPoints(scene.camera.height, step);
  return found;
}

// The pixels of all pictures of the scene in reach of the camera.
int pixelsInReach(const DepthPicture& depth, const View& scene, const DepthComparison& comparison) {
  int sum = comparison.pixelsInReach(depth, kFineColumns);
  for (const SidePicture& side : scene.sides) sum += comparison.pixelsInReach(*side.picture, kFineColumns);
  return sum;
}

// An object in front of the surfaces of an incomplete map is not in it: it is no agreement, but it does not
// contradict, and the surfaces it hides count for nothing. Surfaces seen through the map's contradict as
// ever.
void dropFurniture(DepthEvidence& found) {
  found.of_scene.occluded += std::exchange(found.of_scene.contradict, 0);
  for (DepthAgreement& of_model : found.of_models) of_model.occluded = 0;
}

double weighed(const DepthEvidence& found, MapSurfaces surfaces, const Calibration& calibration) {
  const EvidenceCalibration& params = calibration.evidence;
  const double free_space_share = calibration.score.free_space_share;
  const auto tail = [&](double share) { return std::log1p(share / free_space_share); };
  const double untested = params.untested_pixels * found.pixels;
  const auto contradiction = [&](const DepthAgreement& a, double untested_here) {
    const double n = a.judged() + untested_here;
    return tail(n > 0 ? (a.contradict + untested_here * params.untested_contradiction) / n : 0);
  };
  // The models' pixels are counted on the coarser grid.
  constexpr double kCoarser = double(kCoarseColumns * kCoarseColumns) / (kFineColumns * kFineColumns);
  double of_models = 0, hidden = 0;
  int tested = 0;
  for (const DepthAgreement& a : found.of_models) {
    if (a.judged() == 0) continue;
    ++tested;
    of_models += contradiction(a, kCoarser * untested);
    hidden += tail(a.occluded / static_cast<double>(a.judged()));
  }
  if (tested > 0)
    of_models /= tested, hidden /= tested;
  else
    of_models = contradiction({}, untested);
  const double disagreement = (found.expected - found.of_scene.agree) / std::max(1.0, double(found.pixels));
  // Relative to the pixels of the scene. Fixed surfaces do not move away: free space through one contradicts
  // a pose more, and objects may hide them anywhere.
  const bool are_fixed = surfaces == MapSurfaces::fixed;
  const double looked_through_weight = are_fixed ? 2 : 1, hidden_weight = are_fixed ? 0 : 1;
  return -params.contradiction_weight *
             (contradiction(found.of_scene, untested) + looked_through_weight * of_models) -
         hidden_weight * params.occlusion_weight * hidden - params.disagreement_weight * disagreement;
}

Coverage coverageOf(const DepthEvidence& found, const View& scene, const std::vector<SegmentPair>& pairs) {
  const auto share = [](double part, double of) { return of > 0 ? part / of : 0; };
  const DepthAgreement& a = found.of_scene;
  std::vector<char> has_partner(scene.segments.size(), 0);
  for (const SegmentPair& pair : pairs) has_partner[pair.scene] = 1;
  double all = 0, paired = 0;
  for (std::size_t i = 0; i < scene.segments.size(); ++i) {
    all += scene.segments[i].num_points;
    if (has_partner[i]) paired += scene.segments[i].num_points;
  }
  const DepthAgreement models = found.ofAllModels();
  return {share(a.judged(), found.pixels), share(a.agree, a.judged()), share(a.contradict, a.judged()),
          share(models.contradict, models.judged()), share(paired, all)};
}

bool samePlace(const Hypothesis& a, const Hypothesis& b) {
  return a.part == b.part && a.T_w_c && b.T_w_c && kSamePlace.joins(*a.T_w_c, *b.T_w_c);
}

// Are these answers that exclude each other? Poses that are close to each other are one, found more or less
// well.
bool areRivals(const Hypothesis& a, const Hypothesis& b) {
  if (a.part != b.part) return true;
  if (a.T_w_c && b.T_w_c) return !kSameAnswer.joins(*a.T_w_c, *b.T_w_c);
  return a.model != b.model || !kSameAnswer.joins(a.T_m_c.T, b.T_m_c.T);
}

// Share of the pixels' information that answers of a drive may count: their errors repeat from view to view
// while the sensor's distortion is in the images, so that planes alone count.
double shareOfRepeated(const View& scene) {
  constexpr double kPixelsAsOne = 50;
  return scene.camera && scene.camera->distortion ? 1 / kPixelsAsOne : 0;
}

}  // namespace

HypothesisRanking::HypothesisRanking(const RegistrationParams& params, MapSurfaces surfaces,
                                     const ConsideredErrors& errors)
    : params_(params),
      surfaces_(surfaces),
      errors_(errors),
      comparison_(params.calibration.depth),
      refined_comparison_(refinedErrors(params.calibration)) {}

void HypothesisRanking::rank(const View& scene, std::vector<Hypothesis>& hypotheses,
                             PixelVerdicts& known) const {
  // The paper's score counts pixels: nats of evidence do not add to it.
  const bool evidence = !params_.score.by_overlap && addEvidence(scene, hypotheses, known);
  mergePlaces(params_.merging, hypotheses);
  if (evidence) score(hypotheses);
  if (evidence && params_.refinement.enabled) refinePlaces(scene, hypotheses, known);
  if (evidence && evidenceWeight() != 1) {
    for (Hypothesis& h : hypotheses)
      h.score = std::max(h.consensus + evidenceWeight() * h.evidence, scoreByPixels(scene, h));
    sortByScore(hypotheses);
  }
  const ScoreOdds found = odds(evidence, hypotheses);
  assignProbabilities(found.slope, found.null_score, hypotheses);
}

DepthEvidence HypothesisRanking::compared(const DepthPicture& depth, const View& scene,
                                          const std::vector<NearbyView>& neighbours, const Hypothesis& h,
                                          const DepthComparison& comparison) const {
  DepthEvidence found = ofPicture(depth, *h.T_w_c, neighbours, comparison);
  for (const SidePicture& side : scene.sides) {
    Hypothesis there = h;
    *there.T_w_c = *h.T_w_c * side.T_v_c;
    const DepthEvidence of_side = ofPicture(*side.picture, *there.T_w_c, this->neighbours(there), comparison);
    found.of_scene += of_side.of_scene;
    found.pixels += of_side.of_scene.judged();  // where the map shows nothing, a side says nothing
    found.of_models.insert(found.of_models.end(), of_side.of_models.begin(), of_side.of_models.end());
  }
  return found;
}

double HypothesisRanking::evidence(const View& scene, const LooseBodies& bodies,
                                   const std::vector<NearbyView>& neighbours, Hypothesis& h,
                                   const DepthComparison& comparison) const {
  double found = evidenceOf(scene.depth, scene, neighbours, h, comparison);
  if (h.coverage.contradicted == 0) return found;
  const LooseBodies::Chosen hiding = bodies.before(*h.T_w_c, picturesOf(neighbours), comparison);
  if (!anyOf(hiding)) return found;
  Hypothesis behind = h;
  const double of_rest = evidenceOf(bodies.pictureWithout(hiding), scene, neighbours, behind, comparison);
  if (of_rest > found) found = of_rest, h.coverage = behind.coverage;
  return found;
}

LooseBodies::Chosen HypothesisRanking::furnitureAt(const Hypothesis& h, const LooseBodies& bodies) const {
  if (bodies.empty()) return {};
  return bodies.shown(*h.T_w_c, picturesOf(neighbours(h)), comparison_);
}

double HypothesisRanking::evidenceOf(const DepthPicture& depth, const View& scene,
                                     const std::vector<NearbyView>& neighbours, Hypothesis& h,
                                     const DepthComparison& comparison) const {
  DepthEvidence found = compared(depth, scene, neighbours, h, comparison);
  const bool incomplete = surfaces_ == MapSurfaces::incomplete;
  if (incomplete) dropFurniture(found);
  found.expected = incomplete ? pixelsInReach(depth, scene, comparison) : found.of_scene.judged();
  h.coverage = coverageOf(found, scene, h.pairs);
  return weighed(found, surfaces_, params_.calibration);
}

std::optional<ViewShares> HypothesisRanking::shares(const View& scene, const Hypothesis& h) const {
  if (!h.T_w_c || scene.depth.empty()) return {};
  const DepthEvidence found = compared(scene.depth, scene, neighbours(h), h, comparison_);
  const double pixels = pixelsInReach(scene.depth, scene, comparison_);
  if (found.of_scene.judged() == 0 || pixels == 0) return {};
  ViewShares shares;
  shares.explained = found.of_scene.agree / pixels, shares.hiding = found.of_scene.contradict / pixels;
  shares.fresh = std::max(0.0, (pixels - found.of_scene.agree - found.of_scene.contradict) / pixels);
  const DepthAgreement models = found.ofAllModels();
  shares.missing = models.contradict / std::max(1.0, double(models.judged()));
  return shares;
}

// Moves a hypothesis, within its place, to where the pixels of these models fit best.
void HypothesisRanking::refine(const View& scene, const std::vector<NearbyView>& neighbours,
                               Hypothesis& h) const {
  const std::vector<PosedPicture> pictures = picturesOf(neighbours);
  const Eigen::Isometry3d T_w_m = poseOfModel(h);
  PoseWithCovariance pose = T_w_m * h.T_m_c;
  Matrix6d of_pixels;
  if (!refineByDepth(scene.depth, pictures, {}, pose, &of_pixels)) return;
  if (!kSamePlace.joins(*h.T_w_c, pose.T)) return;  // that is no refinement: planes found another place
  pose.P = symmetricInverse(symmetricInverse(pose.P) + shareOfRepeated(scene) * of_pixels);
  h.T_w_c = pose.T;
  h.T_m_c = T_w_m.inverse() * pose;
}

// Number of sorted hypotheses, limited to `most`, with a chance against the best.
std::size_t HypothesisRanking::hopeful(const std::vector<Hypothesis>& sorted, int most, double slope) const {
  if (sorted.empty()) return 0;
  const double least = sorted.front().score + std::log(params_.calibration.evidence.hopeless_odds) / slope;
  const auto end =
      sorted.begin() + std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(sorted.size()), most);
  const auto isHopeless = [least](const Hypothesis& h) { return h.score < least; };
  return static_cast<std::size_t>(std::find_if(sorted.begin(), end, isHopeless) - sorted.begin());
}

PixelVerdict HypothesisRanking::verdict(const View& scene, const LooseBodies& bodies, Hypothesis h,
                                        bool refined) const {
  const std::vector<NearbyView> models = neighbours(h);
  if (refined) refine(scene, models, h);
  const double evidence_here = evidenceOf(scene.depth, scene, models, h, comparison(refined));
  PixelVerdict out{h.T_m_c, h.T_w_c, evidence_here, h.coverage, !models.empty()};
  if (h.coverage.contradicted > 0)
    out.hiding = bodies.before(*h.T_w_c, picturesOf(models), comparison(refined));
  return out;
}

// The verdicts on the first n hypotheses. Bodies that stand before the map at a place hide it there and say
// nothing against the place, unless the best place shows them: then they are furniture.
std::vector<PixelVerdict> HypothesisRanking::verdicts(const View& scene,
                                                      const std::vector<Hypothesis>& hypotheses,
                                                      std::size_t n, bool refined,
                                                      PixelVerdicts& known) const {
  LooseBodies bodies = known.bodiesOf(scene);
  std::vector<PixelVerdict> found(n);
  std::vector<Hypothesis> judged(hypotheses.begin(), hypotheses.begin() + static_cast<std::ptrdiff_t>(n));
  std::size_t best = n;
  for (std::size_t i = 0; i < n; ++i) {
    Hypothesis& h = judged[i];
    if (!h.T_w_c) continue;
    found[i] = known.of(h, refined, {}, [&] { return verdict(scene, bodies, h, refined); });
    h.T_m_c = found[i].T_m_c, h.T_w_c = found[i].T_w_c, h.score = h.consensus + found[i].evidence;
    if (best == n || h.score > judged[best].score) best = i;
  }
  if (bodies.empty() || best == n) return found;
  bodies.keep(furnitureAt(judged[best], bodies));
  for (std::size_t i = 0; i < n; ++i) {
    Hypothesis& h = judged[i];
    const LooseBodies::Chosen left_out = bodies.otherThanFurniture(found[i].hiding);
    if (!anyOf(left_out)) continue;
    const PixelVerdict& behind = known.of(h, refined, left_out, [&] {
      const double of_rest =
          evidenceOf(bodies.pictureWithout(left_out), scene, neighbours(h), h, comparison(refined));
      return PixelVerdict{h.T_m_c, h.T_w_c, of_rest, h.coverage, true};
    });
    if (behind.evidence > found[i].evidence)
      found[i].evidence = behind.evidence, found[i].coverage = behind.coverage;
  }
  return found;
}

bool HypothesisRanking::addEvidence(const View& scene, std::vector<Hypothesis>& hypotheses,
                                    PixelVerdicts& known) const {
  sortByScore(hypotheses);
  if (!params_.evidence.enabled || scene.depth.empty()) return false;
  const std::size_t n =
      hopeful(hypotheses, params_.evidence.hypotheses, params_.calibration.plain_probability.slope);
  const std::vector<PixelVerdict> said = verdicts(scene, hypotheses, n, false, known);
  bool any = false;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    if (!hypotheses[i].T_w_c) continue;
    hypotheses[i].coverage = said[i].coverage;
    any = any || said[i].compared;
    least = std::min(least, said[i].evidence);
  }
  if (!any) return false;
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    Hypothesis& h = hypotheses[i];
    h.evidence = i < n && h.T_w_c ? said[i].evidence : least;
    h.score = h.consensus + h.evidence;
  }
  return true;
}

void HypothesisRanking::refinePlaces(const View& scene, std::vector<Hypothesis>& hypotheses,
                                     PixelVerdicts& known) const {
  const std::size_t n = hopeful(hypotheses, kRefinedPlaces, params_.calibration.probability.slope);
  const std::vector<PixelVerdict> said = verdicts(scene, hypotheses, n, true, known);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    Hypothesis& h = hypotheses[i];
    if (!h.T_w_c) continue;
    h.T_m_c = said[i].T_m_c, h.T_w_c = said[i].T_w_c;
    h.coverage = said[i].coverage;
    h.evidence = said[i].evidence;
    least = std::min(least, h.evidence);
  }
  // The others are compared with the larger errors of a pose that is not refined, which is no merit.
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    Hypothesis& h = hypotheses[i];
    if (i >= n || !h.T_w_c) h.evidence = std::min(h.evidence, least);
  }
  score(hypotheses);
  mergePlaces(params_.merging, hypotheses);
  score(hypotheses);
}

Matrix6d HypothesisRanking::shownCovariance(const View& scene, const LooseBodies& bodies,
                                            const PoseWithCovariance& prior, const Hypothesis& h) const {
  const std::vector<NearbyView> models = neighbours(h);
  std::vector<PosedPicture> pictures = picturesOf(models);
  const DepthPicture depth = bodies.pictureWithout(bodies.before(*h.T_w_c, pictures, comparison_));
  const Eigen::Isometry3d T_w_m = poseOfModel(h);
  PoseWithCovariance found = T_w_m * h.T_m_c, refined = found;
  Matrix6d of_pixels;
  const double more = 1 / errors_.pixels_as_one - shareOfRepeated(scene);  // that refine() has left out
  if (more > 0 && refineByDepth(depth, pictures, {}, refined, &of_pixels))
    found.P = symmetricInverse(symmetricInverse(found.P) + more * of_pixels);
  DepthFit fit(depth, std::move(pictures), comparison_);
  LocalMap around;
  if (!scene.sides.empty())
    for (const NearbyView& m : models) around.add(0, m.view, m.T_w_m);
  for (const SidePicture& side : scene.sides) fit.add(side, around.picturesNear(found.T * side.T_v_c));
  const PoseWithCovariance shown = asShown(found, T_w_m * prior, fit, kCoarseColumns);
  return (T_w_m.inverse() * shown).P;
}

void HypothesisRanking::stateAsShown(const View& scene,
                                     const std::function<PoseWithCovariance(int model)>& prior_of,
                                     std::vector<Hypothesis>& hypotheses) const {
  constexpr double kPossible = 0.01;  // probability
  const bool by_pixels = !scene.depth.empty() && params_.evidence.enabled && params_.refinement.enabled;
  const LooseBodies bodies(scene);
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    Hypothesis& h = hypotheses[i];
    if (by_pixels && h.T_w_c && (i == 0 || h.probability >= kPossible))
      h.T_m_c.P = shownCovariance(scene, bodies, prior_of(h.model), h);
    h.T_m_c.P = withSharedErrors(h.T_m_c.P, errors_.rotation_std, errors_.translation_std);
  }
}

// Local models see a place from different sides: if several find it independently, their errors hardly
// coincide.
void HypothesisRanking::score(std::vector<Hypothesis>& places) const {
  for (Hypothesis& h : places)
    h.score =
        h.consensus + h.evidence +
        params_.calibration.evidence.support_weight * std::log(std::max(1, viewpoints(h.supporting_models)));
  sortByScore(places);
}

void mergePlaces(const MergingParams& params, std::vector<Hypothesis>& hypotheses) {
  sortByScore(hypotheses);
  if (!params.enabled) return;
  std::vector<Hypothesis> places;
  for (Hypothesis& h : hypotheses) {
    if (h.supporting_models.empty()) h.supporting_models = {h.model};
    const auto known =
        std::find_if(places.begin(), places.end(), [&](const Hypothesis& p) { return samePlace(p, h); });
    if (known == places.end()) {
      places.push_back(std::move(h));
      continue;
    }
    std::vector<int> models;
    std::set_union(known->supporting_models.begin(), known->supporting_models.end(),
                   h.supporting_models.begin(), h.supporting_models.end(), std::back_inserter(models));
    known->supporting_models.swap(models);
  }
  hypotheses.swap(places);
}

void assignProbabilities(double slope, double null_score, std::vector<Hypothesis>& hypotheses) {
  if (hypotheses.empty()) return;
  const double largest = std::max(hypotheses.front().score, null_score);  // keeps the exponentials in range
  double sum = std::exp(slope * (null_score - largest));
  for (Hypothesis& h : hypotheses) sum += h.probability = std::exp(slope * (h.score - largest));
  for (Hypothesis& h : hypotheses) h.probability /= sum;
  for (auto h = hypotheses.begin(); h != hypotheses.end(); ++h) {
    const auto better = std::find_if(hypotheses.begin(), h, [&](const Hypothesis& other) {
      return other.probability > 0 && !areRivals(other, *h);
    });
    if (better != h) better->probability += std::exchange(h->probability, 0);
  }
}

Eigen::Isometry3d quarterTurns(int n) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(n * EIGEN_PI / 2, Eigen::Vector3d::UnitZ()));
}

void discountTurned(Localization& answer) {
  constexpr double kTurned = 0.1;
  double sum = 0;
  for (const Hypothesis& h : answer.hypotheses) sum += h.probability;
  const double all = kTurned * sum + std::max(0.0, 1 - sum);
  for (Hypothesis& h : answer.hypotheses) h.probability *= kTurned / all;
}

void concludePose(const PoseLimits& limits, Localization& answer) {
  if (!answer.hypotheses.empty()) {
    const Hypothesis& first = answer.hypotheses.front();
    answer.fixes_pose = limits.hold(first.T_m_c.P);
    if (!answer.fixes_pose)
      answer.reason = limits.whyNotFixed(first.T_m_c.P, first.T_m_c.T.linear().transpose());
  }
  answer.decide();
}

ScoreOdds oddsOfPair(const RegistrationParams& params, bool evidence) {
  const PairProbabilityCalibration& p = params.calibration.pair_probability;
  const double slope = evidence ? p.slope : p.segments_slope;
  const double null_score = evidence ? p.null_score : p.segments_null_score;
  return {slope, null_score + params.probability.priorLogOdds() / slope};
}

}  // namespace internal

using namespace internal;

bool PoseLimits::hold(const Matrix6d& P) const {
  return kBound * largestTranslationStd(P) <= max_translation &&
         kBound * largestRotationStd(P) <= max_rotation_deg * kDegree;
}

std::string PoseLimits::whyNotFixed(const Matrix6d& P, const Eigen::Matrix3d& R) const {
  return "nothing in view fixes " + openMotions(principalStd(P), R);
}

std::string PoseLimits::openMotions(const PrincipalStd& known, const Eigen::Matrix3d& R) const {
  return freeMotions(known, max_rotation_deg * kDegree / kBound, max_translation / kBound, R);
}

}  // namespace facetloc
