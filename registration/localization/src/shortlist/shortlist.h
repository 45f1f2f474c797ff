// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pairs/consensus.h"
#include "pairs/view_registration.h"
#include "shortlist/known_gravity.h"
#include "shortlist/plane_triplet_matcher.h"

#include <facetloc/localization/localization_params.h>
#include <facetloc/localization/place_index.h>

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace facetloc::internal {

/** \brief Score of a place that is as likely as a wrong one [nats]. */
constexpr double kByChance = 0;

/** \brief A local model that a view is registered with, and about where correspondences are looked for. */
struct Start {
  int model = 0;
  PoseWithCovariance T_m_c;
  bool is_aligned = false;  ///< T_m_c is where a quick alignment has laid the view over the model
};
/** \brief Registered together, before anything is made of their answers; by increasing model. */
using Batch = std::vector<Start>;
/** \brief Makes a batch when it is its turn, by the best score so far of a registration [nats]; lowest
 * without a registration. */
using NextBatch = std::function<Batch(double reached)>;

/** \brief Chooses the local models of a map that a view is registered with, their order, their batches,
 * and the starts.
 *
 * Where the mounting of the camera is the map's, only the models on the list of a PlaceIndex: the likeliest
 * first, then of the others those that come near the best of them at a closer look. For a camera in any
 * attitude, models in the order of a PlaneTripletMatcher: the very likeliest about that alone, then anywhere,
 * then of many others those that come near. All models at once if the map is small or the prior not the usual
 * one. Never changes; thread-safe. */
class Shortlist {
public:
  Shortlist(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params);

  /** \brief At least one batch, which is empty for a view that fixes no pose. If the answer of one is sure,
   * the next ones need not be made. A model that comes again is registered anew, in place of its earlier
   * answer. The query must outlive them. \param on_floor the camera is mounted as the map's, and the query's
   * prior is by this mounting \param threads 0 = all cores \param excluded models, if any are */
  std::vector<NextBatch> batches(const Query& query, bool on_floor, int threads,
                                 const std::function<bool(int model)>& excluded = {}) const;
  const MapGravity& gravity() const { return *gravity_; }

private:
  Batch examined(const Query& query, const Batch& aligned, int most, double reached, int threads) const;
  std::vector<NextBatch> overlaid(const Query& query, int threads,
                                  const std::function<bool(int)>& excluded) const;
  struct ModelPlanes {
    std::vector<PlaneColumns> of_models;
    std::vector<Eigen::Matrix3d> levelling;  // axes of each model; empty where the planes are not levelled
  };
  struct LazyPlanes {
    std::once_flag read;
    ModelPlanes planes;
  };
  ModelPlanes readPlanes(bool levelled) const;
  /** Reads the views of all models at the first call. Levelled ones are empty unless gravity is known in all
   * models. */
  const ModelPlanes& planes(bool levelled) const;
  Batch allModels(const Query& query, const std::function<bool(int)>& excluded) const;
  PoseWithCovariance startAt(const Eigen::Isometry3d& T_m_c,
                             const std::optional<CameraMounting>& mounting) const;

  std::shared_ptr<const Map> map_;
  GlobalLocalizationParams params_;
  ViewRegistration registration_;
  PosePriorParams start_;                    // how well a quick alignment tells a pose
  std::shared_ptr<const PlaceIndex> index_;  // null for a small map, and where there is no mounting
  std::shared_ptr<const MapGravity> gravity_;
  std::shared_ptr<std::array<LazyPlanes, 2>> planes_;  // as they are, and levelled; null in a small map
};

}  // namespace facetloc::internal
