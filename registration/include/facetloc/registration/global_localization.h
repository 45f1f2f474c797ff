// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/place_index.h>
#include <facetloc/registration/place_ranking.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/registration/view_registration.h>

#include <functional>
#include <memory>

namespace facetloc {

struct GlobalLocalizationParams {
  PosePriorParams prior;
  ViewRegistrationParams registration;
  PlaceRankingParams ranking;
  PlaceIndexParams index;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    PosePriorParams::describe(p.prior, field);
    ViewRegistrationParams::describe(p.registration, field);
    PlaceRankingParams::describe(p.ranking, field);
    PlaceIndexParams::describe(p.index, field);
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Finds a view in a map: registers it with every local model and returns one ranked list of places.
 *
 * With a known camera mounting it registers with the models on a shortlist only (PlaceIndex), unless the map
 * is small or the prior wider than the usual one, about the poses that the shortlist tells. The index comes
 * with the file of a large map or is made with the object.
 *
 *     facetloc::GlobalLocalization localization(map);           // shared, never changed
 *     facetloc::Localization answer = localization.localize(view);
 *     if (answer.hypotheses.empty()) std::cout << answer.reason;
 *     else use(*answer.hypotheses[0].T_w_c, answer.hypotheses[0].probability);
 *
 * The answer is the same for any number of threads. */
class GlobalLocalization {
public:
  /** \brief Throws std::invalid_argument for a parameter out of its range. */
  explicit GlobalLocalization(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params = {},
                              const SensorNoise& noise = {});
  const Map& map() const { return *map_; }
  /** \brief OpenMP threads over local models; 1 by default, 0 = all cores. */
  void setNumberOfThreads(int n) { threads_ = n; }

  /** \brief Thread-safe. A view without segments, an empty map, and views that fix no pose give a reason. */
  Localization localize(const View& scene) const;
  /** \brief The same with another prior of the pose relative to each local model; with all models if it
   * reaches farther than the index. One whose covariance is not positive definite gives a reason. */
  Localization localize(const View& scene, const PoseWithCovariance& prior) const;

  /** \name The parts of localize(), for who deals out the local models */
  //@{
  /** \brief The local models that localize() registers a view with, by increasing index: the shortlist, or
   * all of a small map, and for a view that has nothing to look up. */
  std::vector<Candidate> candidates(const View& scene) const;
  /** \brief Registers the view with some local models of the map. \return their hypotheses, in the order of
   * the candidates given, unranked. */
  std::vector<Hypothesis> registerWith(const std::vector<Candidate>& candidates, const View& scene,
                                       const PoseWithCovariance& prior) const;
  /** \brief What registerWith() does with the map's prior, by whoever does it. */
  using Registering = std::function<std::vector<Hypothesis>(const std::vector<Candidate>&)>;
  /** \brief localize(); registers a second time, with the less likely models of the shortlist, if the answer
   * of the likeliest is in doubt. */
  Localization localizeBy(const Registering& registerAll, const View& scene) const;
  /** \brief Ranks the hypotheses of the whole map. */
  Localization rank(const View& scene, std::vector<Hypothesis> hypotheses) const;
  //@}
  /** \brief Prior of the pose relative to each local model, from the camera's mounting. */
  const PoseWithCovariance& prior() const { return prior_; }

private:
  std::vector<Candidate> shortlist(const View& scene) const;
  std::vector<Candidate> allModels() const;
  PoseWithCovariance startOf(const Candidate& candidate) const;

  std::shared_ptr<const Map> map_;
  GlobalLocalizationParams params_;
  ViewRegistration registration_;
  PlaceRanking ranking_;
  PoseWithCovariance prior_;
  PosePriorParams start_;                    // how well a quick alignment tells a pose
  std::shared_ptr<const PlaceIndex> index_;  ///< of a large map
  int threads_ = 1;
};

}  // namespace facetloc
