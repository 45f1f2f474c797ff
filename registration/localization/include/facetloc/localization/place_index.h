// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/registration/pose_prior.h>

#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <vector>

namespace facetloc {

/** \brief A local model that may show the place of a view. */
struct ShortlistedModel {
  int model = 0;
  int rank = 0;  ///< 0 = the likeliest
  /// T_m_c by a quick alignment; none: anywhere that the prior allows
  std::optional<Eigen::Isometry3d> start;
};

/** \brief Selects the local models of a large map that may show the place of a view.
 *
 *     facetloc::PlaceIndex index(map);
 *     for (const int model : index.shortlist(view, 150)) ...
 *
 * Upper and lower edges of the walls of all models are descriptors in a FLANN tree, in units of how much they
 * may differ between two views of a place: standard deviations of the pose for where an edge is, of its error
 * for how high. Those of a view vote for the models with similar ones, by nearness and rarity, and only
 * those agreeing on one heading add up. Votes and the Prescore rank all models. The best of them are aligned
 * with the view (CoarseAligner), and come out in the order of its score, to which the prescore adds a little.
 *
 * Needs a map whose camera mounting is known. Never changes; all functions are thread-safe. The same map
 * gives the same answers. */
class PlaceIndex {
public:
  /** \brief Throws std::invalid_argument if the map tells no camera mounting. */
  explicit PlaceIndex(const Map& map, const ShortlistParams& params = {}, const PosePriorParams& prior = {});
  /** \brief Whether an index finds the models that a prior of T_m_c leads to: views up to 60 deg and 2.8 m
   * apart are compared, three standard deviations of the usual prior. */
  static bool covers(const PoseWithCovariance& prior);
  /** \brief The index that is written in the map's store, if it is one of this map and prior; else made. */
  static PlaceIndex of(const Map& map, const ShortlistParams& params = {}, const PosePriorParams& prior = {});
  /** \brief Writes it for this program on machines of this kind. The same map gives the same bytes. */
  void write(std::ostream& out) const;
  /** \brief The index that write() wrote, or nothing if that was for another map or prior, or by another
   * version. Throws std::runtime_error if the bytes end too early or hold invalid values, and the exceptions
   * of the stream. */
  static std::optional<PlaceIndex> read(std::istream& in, const Map& map, const ShortlistParams& params = {},
                                        const PosePriorParams& prior = {});
  PlaceIndex(PlaceIndex&&) noexcept;
  PlaceIndex& operator=(PlaceIndex&&) noexcept;
  ~PlaceIndex();

  /** \brief The at most n models most similar to the view and not far worse than the best, the likeliest
   * first; ties by index. Empty for a view without a wall and without a level surface. */
  std::vector<int> shortlist(const View& view, int n) const;
  /** \brief The same with the poses of the quick alignment, without the models that are excluded, if any are.
   */
  std::vector<ShortlistedModel> candidates(const View& view, int n,
                                           const std::function<bool(int model)>& excluded = {}) const;
  std::size_t models() const;
  std::size_t descriptors() const;

private:
  struct Impl;
  explicit PlaceIndex(std::unique_ptr<const Impl> impl);
  std::unique_ptr<const Impl> impl_;
};

/** \brief Writes the place index that a map file is to keep. Empty for a map of at most 400 local models, of
 * whose views an index is soon made, and if the mounting of its camera is unknown. */
std::function<void(std::ostream&)> placeIndexOf(const Map& map);

}  // namespace facetloc
