// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>
#include <facetloc/registration/place_signature.h>

#include <iosfwd>
#include <memory>
#include <optional>
#include <vector>

namespace facetloc {

/** \brief When the search of a map is cut short, and how. */
struct PlaceIndexParams {
  int shortlist = 40;              ///< most local models that a view is registered with; 0 = always all
  int examined_models = 200;       ///< of larger maps than are aligned: best aligned models that are examined
  double examined_gap = 20;        ///< score below the best of these at which one is hopeless [nats]
  double shortlist_gap = 1.2;      ///< score below the best at which a local model is hopeless
  int exhaustive_up_to = 5;        ///< local models of a map that is small
  int aligned_models = 3000;       ///< local models that are aligned with a view
  int first_models = 10;           ///< likeliest ones that a view is registered with first
  double sure_probability = 0.95;  ///< of a place that they show, with which no others are asked
  double start_translation = 0.2;  ///< how well an alignment tells the position, standard deviation [m]
  double start_rotation_deg = 3;   ///< and the heading

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("shortlist", p.shortlist, 0, 100000000,
          "Largest number of local models that a view is registered with; 0 = always all.");
    field(
        "shortlist_examined", p.examined_models, 1, 100000000,
        "In maps of more local models than are aligned: number of best aligned ones that are examined by all "
        "planes for the shortlist.");
    field("examined_gap", p.examined_gap, 0.0, 1e6,
          "Examined local models that score so much less than the best one are not registered with [nats].");
    field("shortlist_gap", p.shortlist_gap, 0.0, 1e6,
          "Local models whose quick alignment scores so much less than the best are not registered with.");
    field("exhaustive_up_to", p.exhaustive_up_to, 0, 100000000,
          "A map of so many local models is small: the view is registered with all of them.");
    field("shortlist_aligned", p.aligned_models, 1, 100000000,
          "Number of local models, chosen by votes and outlook, that are aligned quickly.");
    field("first_models", p.first_models, 1, 100000000,
          "Number of likeliest local models of the shortlist that a view is registered with first.");
    field("sure_probability", p.sure_probability, 0.0, 1.0,
          "If the best place that those show is so probable, the view is not registered with the others.");
    field("start_translation", p.start_translation, 0.0, 100.0,
          "Standard deviation of the position in a local model by its quick alignment, from which a view is "
          "registered with it [m]; 0 = the prior's.");
    field("start_rotation_deg", p.start_rotation_deg, 0.01, 180.0, "The same of the heading [deg].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief A local model that may show the place of a view. */
struct Candidate {
  int model = 0;
  int rank = 0;  ///< 0 = the likeliest
  /// T_m_c by a quick alignment; none: anywhere that the prior allows
  std::optional<Eigen::Isometry3d> start;
};

/** \brief Tells which local models of a large map may show the place of a view.
 *
 *     facetloc::PlaceIndex index(map);
 *     for (const int model : index.shortlist(view, 150)) ...
 *
 * Upper and lower edges of the walls of all models are descriptors in a FLANN tree, in units of how much they
 * may differ between two views of a place: standard deviations of the pose for where an edge is, of its error
 * for how high. Those of a view vote for the models that have alike ones, by nearness and rarity, and only
 * those agreeing on one heading add up. Votes and outlook (PlaceOutlook) tell how much is to be hoped for
 * from each model. Those that give most hope are aligned with the view (PlaceAligner), and come out in the
 * order of that, to which hope adds a little.
 *
 * Needs a map whose camera mounting is known. Never changes; all functions are thread-safe. The same map
 * gives the same answers. */
class PlaceIndex {
public:
  /** \brief Throws std::invalid_argument if the map tells no camera mounting. */
  explicit PlaceIndex(const Map& map, const PlaceIndexParams& params = {}, const PosePriorParams& prior = {});
  /** \brief Whether an index finds the models that a prior of T_m_c leads to: views up to 60 deg and 2.8 m
   * apart are compared, three standard deviations of the usual prior. */
  static bool covers(const PoseWithCovariance& prior);
  /** \brief The index that is written in the map's store, if it is one of this map and prior; else made. */
  static PlaceIndex of(const Map& map, const PlaceIndexParams& params = {},
                       const PosePriorParams& prior = {});
  /** \brief Writes it for this program on machines of this kind. The same map gives the same bytes. */
  void write(std::ostream& out) const;
  /** \brief What write() wrote, or nothing if that was for another map or prior, or by another version.
   * Throws std::runtime_error if the bytes end too early, and what the stream throws. */
  static std::optional<PlaceIndex> read(std::istream& in, const Map& map, const PlaceIndexParams& params = {},
                                        const PosePriorParams& prior = {});
  PlaceIndex(PlaceIndex&&) noexcept;
  PlaceIndex& operator=(PlaceIndex&&) noexcept;
  ~PlaceIndex();

  /** \brief The at most n models most like the view that are not hopeless beside the best, the likeliest
   * first; ties by index. Empty for a view without a wall and without a level surface. */
  std::vector<int> shortlist(const View& view, int n) const;
  /** \brief The same with the poses of the quick alignment. */
  std::vector<Candidate> candidates(const View& view, int n) const;
  std::size_t models() const;
  std::size_t descriptors() const;
  std::size_t bytes() const;  ///< of memory, about

private:
  struct Impl;
  explicit PlaceIndex(std::unique_ptr<const Impl> impl);
  std::unique_ptr<const Impl> impl_;
};

}  // namespace facetloc
