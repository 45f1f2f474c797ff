// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "motion/camera_motion.h"
#include "ranking/place_ranking.h"

#include <facetloc/features/local_model.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/registration/hypothesis.h>

#include <deque>
#include <memory>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief Largest log odds that any number of views add up to [nats]: the camera may be moved meanwhile. */
constexpr double kMostLogOdds = 7;

/** \brief A place where a camera may be. */
struct BelievedPlace {
  PoseWithCovariance T_w_c;
  int part = 0;         ///< part of the map in whose frame the pose is
  double log_odds = 0;  ///< against that the map does not hold the place [nats]
  Hypothesis
      match{};  ///< with a local model, as of the latest observation; no pairs once the camera has moved
  double spread = 0;       ///< log of as many local models as its Gaussian covers, which its odds know of
  double probability = 0;  ///< beside the other places and that
};

/** \brief The belief by all views of a moving camera: Gaussian places with their odds
 * against that it is nowhere in the map (METHOD 3.5).
 *
 * A place moves with the camera. Each view adds its log odds at this very pose to those of the place, as the
 * ranking of a search weighs it. Errors of views close to each other are correlated: an observation counts by
 * 1 - exp(-motion since the last one / independent motion), so that neither a high frame rate nor standing
 * still sharpens anything. A place that a search brings up is judged by the latest observations too, before
 * it is put beside the others. */
class PlaceBelief {
public:
  PlaceBelief(std::shared_ptr<const Map> map, const GlobalLocalizationParams& localization,
              const LocalizerParams& params);

  /** \brief Nothing is known. */
  void clear();
  /** \brief The camera has moved: each place becomes as many as the motion has modes. */
  void move(const Motion& motion);
  /** \brief Has it moved so far that an observation tells something new? True before the first. */
  bool isDue() const;
  /** \brief Compares a view with all places.
   * \param view where the camera is now; it is kept for a while
   * \param found result of a search of the map, or of a part of it, for this view \param independent the view
   * has nothing in common with the ones before, however little the camera may have moved \return change of
   * the log odds of the place that was most probable [nats]; nothing without a place, or if the map has
   * nothing near it. */
  std::optional<double> observe(std::shared_ptr<const View> view, const Localization& found,
                                bool independent = false);
  /** \brief Hears a view that is sure, on its own, of another place than the one believed: that has at least
   * the odds of the view, less the doubt that the motions since the observations before raise. */
  void hear(const Hypothesis& sure);
  /** \brief The n local models nearest to each place that is worth asking about. */
  std::vector<int> modelsAround(int n) const;
  /** \brief Somebody says that the camera is there: adds a place, or one for each of 12 headings if the
   * standard deviation about the z axis of the part exceeds 60 deg. Nothing happens in a part without poses.
   * \param part of the map \param log_odds against any other place [nats] */
  void inject(int part, const PoseWithCovariance& T_w_c, double log_odds = 0);
  /** \brief The pose of the most probable place, of which there is one, as it follows from the latest view.
   * \param match the local model that shares most with the view; without one it stays */
  void correct(const PoseWithCovariance& T_w_c, const std::optional<Hypothesis>& match = {});

  /** \brief Most probable first; their probabilities add up to at most 1, and the rest is that the camera is
   * nowhere in the map. */
  const std::vector<BelievedPlace>& places() const { return places_; }
  /** \brief Number of observations since nothing was known. */
  int observations() const { return observations_; }
  void setNumberOfThreads(int n) { threads_ = n; }

private:
  struct Observation {  // that is kept
    std::shared_ptr<const View> view;
    std::vector<MotionMode> T_c_l;  // modes of the motion since, from the present camera
    double weight;
    double best;  // log odds of the place that it liked best
  };
  struct Candidate {  // for where a view was taken, near a believed place
    Hypothesis match;
    PoseWithCovariance T_w_c;  // pose by the view and the place
    double log_odds = 0;       // log odds by the view
  };
  using Candidates = std::vector<Candidate>;
  double motionSince(double distance, double rotation_deg) const;
  double oddsOfKnown(const View& view, const Hypothesis& h) const;
  static double spreadOf(const Matrix6d& P);
  double oddsOfEstablished(const View& view, const Hypothesis& h) const;
  double historyOf(const Hypothesis& place) const;
  std::vector<Hypothesis> sortFound(const Localization& found, std::vector<Candidates>& seen) const;
  static std::vector<BelievedPlace> updated(const BelievedPlace& place, const Candidates& seen, double best,
                                            double weight);
  double addFresh(const View& view, const std::vector<Hypothesis>& fresh, const std::vector<Candidates>& seen,
                  double weight);
  PoseWithCovariance poseOf(const Hypothesis& h) const;
  void scatter(double probability);
  void normalize();
  void weigh();  // probabilities by the odds

  std::shared_ptr<const Map> map_;
  LocalizerParams params_;
  SequenceCalibration calibration_;
  double prior_;  // that the map holds the place, as log odds
  PlaceRanking ranking_;
  NearbyModels near_;
  PoseLimits limits_;
  std::vector<BelievedPlace> places_;
  std::deque<Observation> kept_;
  double distance_ = 0, turn_ = 0;  // since the last observation [m, rad]
  int observations_ = 0;
  int threads_ = 1;
};

/** \brief The places of a view by the views up to it and by those from the next one on (METHOD 3.6): most
 * probable first, with `nowhere` and `looks`; state and reason are left to the caller.
 * \param prior log odds that the map holds a place, which both answers have in them [nats] */
Localization smoothedPlaces(const Localization& until_now, const Localization& from_next,
                            const PoseWithCovariance& T_now_next, double prior);

}  // namespace facetloc::internal
