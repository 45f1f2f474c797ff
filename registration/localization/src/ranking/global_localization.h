// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pairs/view_registration.h"
#include "ranking/place_ranking.h"
#include "shortlist/shortlist.h"

#include <facetloc/features/local_model.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/registration/hypothesis.h>

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief Finds a view in a map: registers it with local models and returns one ranked list of places.
 *
 *     const GlobalLocalization localization(map);      // shared, never changed
 *     ViewBuilder builder(map->calibrated(camera));
 *     const Localization answer = localization.localize(builder.build(image));
 *     if (answer.hypotheses.empty()) std::cout << answer.reason;
 *     else use(*answer.hypotheses[0].T_w_c, answer.hypotheses[0].probability);
 *
 * Compares the camera of the view with the map's. On a robot, where the mounting is the map's, the floor
 * gives roll, pitch and height beforehand, and the view is registered with the local models of a shortlist
 * only; otherwise, and with an unknown camera of the view, the prior is isotropic and all local
 * models are compared. An index for the shortlist comes with the file of a large map or is made with the
 * object.
 *
 * For two known mountings that differ, the prior is about their difference, such as half a turn of a
 * camera mounted upside down. Where one of them is unknown and the best place is improbable, the view is
 * also searched for as seen by a camera rolled by 90, 180 and 270 deg about its optical axis. A place that is
 * sure so is the answer, with the probability that it has if one camera of ten is rolled.
 *
 * The answer is the same for any number of threads. */
class GlobalLocalization {
public:
  /** \brief Throws std::invalid_argument for a parameter out of its range. */
  explicit GlobalLocalization(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params = {});
  const Map& map() const { return *map_; }
  /** \brief OpenMP threads over local models; 1 by default, 0 = all cores. */
  void setNumberOfThreads(int n) { threads_ = n; }

  /** \brief Thread-safe. A view without segments, an empty map, and views that fix no pose give a reason. */
  Localization localize(const View& view) const;

  /** \brief Localizes without the excluded local models. For callers that weigh the answers further:
   * covariances are by the derivatives of planes and pixels alone, not by the shape of the cost
   * (registration/METHOD 11.4). Excluded ones still give evidence of the places that others find. */
  Localization localize(const View& view, const std::function<bool(int model)>& excluded) const;
  /** \brief The same for a camera that stays rolled. \param quarters of a turn about its optical axis against
   * the map's cameras; empty while unknown, and filled in by an answer that is sure */
  Localization localize(const View& view, const std::function<bool(int model)>& excluded,
                        std::optional<int>& quarters) const;
  /** \brief Its localize(view) answers as in the map without the absent local models, which neither find a
   * place nor give evidence of one. Large data are shared. */
  GlobalLocalization without(std::function<bool(int model)> absent) const;

  /** \brief The shares of a view and of the map at the first place of an answer. */
  std::optional<ViewShares> shares(const View& view, const Localization& answer) const;

  /** \brief Prior of the pose of a view relative to each local model, from the mounting of its camera. */
  PoseWithCovariance prior(const View& view) const;

private:
  PoseWithCovariance priorOf(const View& view, const CameraDifference& camera) const;
  PoseWithCovariance priorOfRoll(int quarters) const { return {quarterTurns(quarters), anywhere_.P}; }
  Query queryOf(const View& view, const CameraDifference& camera) const;
  bool isLevelIn(const View& view) const;
  std::optional<Gravity> gravityOf(const View& view, int model, const View& of_model) const;
  bool mayBeTurned(const Localization& answer) const;
  void registerWith(const Batch& batch, const Query& query, bool keeps_mean,
                    std::vector<Hypothesis>& hypotheses) const;
  Localization rank(const Query& query, std::vector<Hypothesis> hypotheses, PixelVerdicts& known) const;
  Localization search(const Query& query, const CameraDifference& camera,
                      const std::function<bool(int)>& excluded,
                      double promising = std::numeric_limits<double>::lowest()) const;
  bool isSure(const Localization& answer) const;

  std::shared_ptr<const Map> map_;
  GlobalLocalizationParams params_;
  ViewRegistration registration_;
  Shortlist shortlist_;
  PlaceRanking ranking_;
  PoseWithCovariance on_floor_, anywhere_;  // priors of a camera mounted as the map's, and of any other
  Matrix6d of_floor_ = Matrix6d::Zero();    // information of the floor about a pose
  int threads_ = 1;
  std::function<bool(int)> absent_;  // local models of the map that count as missing; may be empty
};

}  // namespace facetloc::internal
